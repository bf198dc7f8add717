"""What waits between Zenoh's threads and a loop, while others send more than it can take."""

from hub.zenoh.handover import Handover, Work


def test_a_stop_comes_through_a_flood_of_tokens() -> None:
    posted: list[Work] = []
    done: list[str] = []
    handover = Handover(posted.append, most=10)
    for number in range(1000):
        handover.add(lambda each=f"token {number}": done.append(each), keep=True)
    handover.add(lambda: done.append("stop"), name="stop", keep=True)
    while posted:
        posted.pop()()
    assert done[-1] == "stop"
    assert len(done) == 10
    assert handover.dropped == 991
