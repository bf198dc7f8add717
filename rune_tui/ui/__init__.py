"""The parts of the console that use Textual: screen, inputs, clock, driver."""
