"""Formulas of coordinates, which place bodies: worked out for all records at once. The grammar is
that of the library (lib/io/formula.h), which has checked them when the file was written."""

import re

import numpy as np

from trajectory import Problem

NESTED_MOST = 100  # parentheses, calls and signs in each other: five frames of the parser each, of the 1000 of Python
SYMBOL = re.compile(r" *(?:(\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?)|([A-Za-z_]\w*)|(.)|$)", re.ASCII)

FUNCTIONS = {
    "sin": (np.sin, 1), "cos": (np.cos, 1), "tan": (np.tan, 1), "asin": (np.arcsin, 1), "acos": (np.arccos, 1),
    "atan": (np.arctan, 1), "atan2": (np.arctan2, 2), "sqrt": (np.sqrt, 1), "exp": (np.exp, 1), "log": (np.log, 1),
    "abs": (np.abs, 1), "min": (np.minimum, 2), "max": (np.maximum, 2), "hypot": (np.hypot, 2),
}


def shortened(text):
    return text if len(text) <= 80 else f"{text[:77]}..."


class Reader:
    """Recursive descent; a method per line of the grammar."""

    def __init__(self, text, names):
        self.text, self.names, self.at, self.depth = text, names, 0, 0
        self.number = self.name = self.symbol = None
        self.advance()

    def advance(self):
        found = SYMBOL.match(self.text, self.at)
        self.number, self.name, self.symbol = found.groups()
        self.at = found.end()

    def refuse(self, what):
        raise Problem(f"the formula '{shortened(self.text)}' cannot be read: {what}")

    def take(self, symbol):
        if self.symbol != symbol:
            return False
        self.advance()
        return True

    def need(self, symbol):
        if not self.take(symbol):
            self.refuse(f"no {symbol} where it should stand")

    def sum(self):
        value = self.product()
        while self.symbol in ("+", "-"):
            sign = 1 if self.symbol == "+" else -1
            self.advance()
            value = value + sign * self.product()
        return value

    def product(self):
        value = self.sign()
        while self.symbol in ("*", "/"):
            divide = self.symbol == "/"
            self.advance()
            value = value / self.sign() if divide else value * self.sign()
        return value

    def sign(self):
        """Every recursion passes here."""
        self.depth += 1
        if self.depth > NESTED_MOST:
            self.refuse(f"it is nested deeper than {NESTED_MOST}")
        value = self.signed()
        self.depth -= 1
        return value

    def signed(self):
        if self.take("+"):
            return self.sign()
        if self.take("-"):
            return -self.sign()
        value = self.atom()
        return np.power(value, self.sign()) if self.take("^") else value

    def atom(self):
        number, name = self.number, self.name
        if self.take("("):
            value = self.sum()
            self.need(")")
            return value
        self.advance()
        if number is not None:
            return np.float64(number)
        if name in FUNCTIONS:
            return self.call(*FUNCTIONS[name])
        if name not in self.names:
            self.refuse(f"no value for '{name}'" if name else "a value is missing")
        return self.names[name]

    def call(self, function, count):
        self.need("(")
        values = [self.sum()]
        for _ in range(count - 1):
            self.need(",")
            values.append(self.sum())
        self.need(")")
        return function(*values)


def names_in(text):
    return {found[2] for found in SYMBOL.finditer(text) if found[2]}


def evaluate(text, names):
    """Its value, or its values [n] where it depends on the record; names: what may stand in it."""
    reader = Reader(text, names)
    with np.errstate(all="ignore"):
        value = reader.sum()
    if any(part is not None for part in (reader.number, reader.name, reader.symbol)):
        reader.refuse("it goes on where it should end")
    if not np.all(np.isfinite(value)):
        raise Problem(f"the formula '{shortened(text)}' is not finite at some time")
    return value
