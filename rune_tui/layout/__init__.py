"""The operator's XML file: schema, loader, frozen specs."""
