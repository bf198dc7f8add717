"""It cannot be made."""

from rune_tui.layout.rules import HandlerRule, VisualizerRule


class Shown:
    """It cannot be made."""

    rule = VisualizerRule(meaning="nothing")
    whole_cells = True

    @classmethod
    def from_spec(cls, spec):
        raise ValueError("it needs a compass")

    def draw(self, canvas, robot, state):
        pass

    def source(self, robot, state):
        return None


class Pressed:
    """Its rule is right."""

    rule = HandlerRule(meaning="nothing", needs_robot=False)

    @classmethod
    def from_spec(cls, spec, robot):
        raise KeyError(spec.handler)

    def handle(self, event, event_spec, state):
        return ()

    def tick(self, state):
        return ()

    def release(self, state):
        return ()


VISUALIZERS = {"visualizeUnmade": Shown}
WIDGETS = {"widgetUnmade": Pressed}

