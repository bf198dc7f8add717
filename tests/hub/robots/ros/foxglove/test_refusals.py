"""What a bridge does not serve, by its errors; time is given, sockets are real."""

from tests.hub.robots.ros.foxglove.scripted_bridge import GREETING, channel


def test_the_errors_of_a_bridge_are_those_of_the_topics_that_they_name(both):
    """Each in the words of a bridge for ROS 1 or ROS 2."""
    pair = both(greeting={**GREETING, "supportedEncodings": ["ros1"]})
    pair.line.advertise("/cmd_vel", "geometry_msgs/msg/Twist")
    pair.line.advertise("/light", "std_msgs/msg/Bool")
    pair.line.advertise("/arm", "std_msgs/msg/Float64")
    pair.wait(lambda: pair.line.state.up)
    topics = [channel(number, name) for number, name in enumerate(("/odom", "/scan"))]
    pair.bridge.say({"op": "advertise", "channels": topics})
    found = []
    for name in ("/odom", "/scan"):
        pair.line.subscribe(name, lambda message: found.append(message.topic.name))
    pair.wait(lambda: len(pair.bridge.subscriptions()) == 2)
    pair.bridge.say(
        {"op": "advertiseServices", "services": [{"id": 3, "name": "/e_stop", "type": "a/B"}]}
    )
    pair.wait(lambda: "/e_stop" in pair.line.graph.services)
    answers = []
    pair.line.call("/e_stop", b"", lambda _, why: answers.append(why), 5.0)
    own = {
        each["topic"]: each["id"]
        for text in pair.bridge.texts
        if text["op"] == "advertise"
        for each in text["channels"]
    }
    words = {
        "/cmd_vel": "Failed to retrieve type information of data type 'geometry_msgs/Twist'. "
        "Unable to advertise topic /cmd_vel",
        "/light": "Failed to create publisher: no type support for std_msgs/msg/Bool",
        "/arm": f"Client channel {own['/arm']} is not served",
        "/odom": "Failed to subscribe to topic /odom (nav_msgs/msg/Odometry): no library",
        "/e_stop": "Failed to call service /e_stop: it is not there",
    }
    for level, text, name in (
        *((2, each, "") for each in words.values()),
        (1, "/scan is slow", ""),
        (2, "Failed to subscribe to topic /scan/raw, and to /front/scan", ""),
        (2, "the disk is full", "disk"),
    ):
        pair.bridge.say({"op": "status", "level": level, "message": text, "id": name})
    pair.wait(lambda: "the disk is full" in pair.line.state.notes)
    assert dict(pair.line.state.refusals) == words

    pair.bridge.send(pair.bridge.data(pair.bridge.subscriptions()[0], b"x"))
    pair.wait(lambda: found == ["/odom"])
    pair.line.unadvertise("/light")
    assert pair.line.state.refusals.keys() == words.keys() - {"/odom", "/light"}
    pair.bridge.say({"op": "status", "level": 2, "message": "no more of /scan", "id": "s"})
    pair.wait(lambda: "/scan" in pair.line.state.refusals)
    pair.bridge.say({"op": "removeStatus", "statusIds": ["s"]})
    pair.wait(lambda: "/scan" not in pair.line.state.refusals)
    pair.bridge.hang_up()
    pair.wait(lambda: not pair.line.state.up)
    assert not pair.line.state.refusals
