"""The link shaper: carries a console's connection to a hub as a bad radio link would."""
