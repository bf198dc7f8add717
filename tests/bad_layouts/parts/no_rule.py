"""Offers a class without a rule."""

WIDGETS = {"widgetNothing": dict}
