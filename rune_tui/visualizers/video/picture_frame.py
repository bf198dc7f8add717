"""The place of the camera's picture in a viewport, so that overlays match it."""

from __future__ import annotations

from typing import Final, Self

from hub.values import dataclass
from rune_tui.layout.rules import ChoiceOption
from rune_tui.model.geometry import PictureGeometry
from rune_tui.raster.resize import covering_size, fitted_size

FIT: Final = "fit"
FILL: Final = "fill"
STRETCH: Final = "stretch"

_FINE: Final = 1000
"""Resolution of the shape of a pixel [1/pixel]."""

FIT_OPTION: Final = ChoiceOption(
    default=FIT,
    choices=(FIT, FILL, STRETCH),
    meaning="the whole picture, bars beside it; as much of it as covers the viewport; or all of "
    "it, drawn out of shape to cover the viewport",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class PictureFrame:
    """The rectangle of a viewport that a whole picture takes [pixels]; may reach beyond it.

    Attributes:
        left: Column of its left edge.
        top: Row of its upper edge.
        width: Its width.
        height: Its height.
    """

    left: int
    top: int
    width: int
    height: int

    @classmethod
    def of(
        cls, fit: str, width: int, height: int, room: tuple[int, int], *, tall: float = 1.0
    ) -> Self:
        """The place of a picture.

        Args:
            fit: One of the choices of `FIT_OPTION`.
            width: Width of the picture [pixels].
            height: Height of the picture [pixels].
            room: Width and height of the viewport [pixels].
            tall: Height of the viewport's pixels over their width; the picture's are square.
        """
        if fit == STRETCH:
            size = room
        else:
            sized = covering_size if fit == FILL else fitted_size
            size = sized(round(_FINE * tall * width), _FINE * height, *room)
        return cls(
            left=(room[0] - size[0]) // 2,
            top=(room[1] - size[1]) // 2,
            width=size[0],
            height=size[1],
        )

    def shares(self, pixel: tuple[float, float]) -> tuple[float, float] | None:
        """A pixel's place as shares of the picture's width and height; None beside it."""
        across = (pixel[0] - self.left) / self.width
        down = (pixel[1] - self.top) / self.height
        return (across, down) if 0.0 <= across <= 1.0 and 0.0 <= down <= 1.0 else None

    def shown(self, geometry: PictureGeometry) -> PictureGeometry:
        """A picture's geometry as it is drawn here."""
        return geometry.shown(self.left, self.top, self.width, self.height)
