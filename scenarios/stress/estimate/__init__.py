"""The probability of a failure under the nominal distribution, with its interval."""
