"""Random G-code that computes: assignments, expressions and calls of programs in the file, as LinuxCNC has them."""

from __future__ import annotations

import random

FUNCTIONS = ("ABS", "SQRT", "SIN", "COS", "TAN", "ASIN", "ACOS", "ROUND", "FIX", "FUP", "LN", "EXP")


class RandomFormulas:
    """A program whose coordinates are formulas; ``text`` is all of it."""

    def __init__(self, seed: int, blocks: int = 40) -> None:
        self.rng = random.Random(seed)
        self.names = ["#1", "#<depth>", "#<_all>"]
        main = [f"O1 (seed {seed})", "G21 G90 G17", "F500", "#1=2.5", "#<depth> = -1.5 #<_all>=1.25", "G0 X0 Y0 Z0"]
        main += [self.block() for _ in range(blocks)]
        main.append(f"M98 P100 L{self.rng.randint(1, 4)}")
        main.append("G1 X#<depth> Y#1 Z#<_all>")
        subs = ["O100", "#1=[#1 + 0.25]", "G91", "G1 X#1", "M98 P200", "G90", "M99"]
        subs += ["O200", "#<depth> = 3", "G1 Y[#<depth> / #<_all>]"]
        subs += ["#<_all> = [#<_all> + 1]", "M99"]
        self.text = "\n".join(["%", *main, "M30", *subs, "%"]) + "\n"

    def value(self, depth: int = 0) -> str:
        """What may stand where a number stands."""
        kind = self.rng.random()
        if kind < 0.3:
            return f"{self.rng.uniform(-9, 9):.3f}"
        if kind < 0.6 or depth > 0:
            return self.rng.choice(["", "-"]) + self.rng.choice(self.names)
        return f"[{self.formula(depth + 1)}]"

    def formula(self, depth: int) -> str:
        """What stands inside brackets; every function gets a value that it has."""
        terms = [self.value(depth)]
        if self.rng.random() < 0.3:
            function = self.rng.choice(FUNCTIONS)
            inner = f"SIN[{self.value(depth)}]"  # -1 ... 1
            terms = [f"{function}[{inner if function in ('ASIN', 'ACOS', 'EXP') else f'ABS[{inner}] + 0.5'}]"]
        elif self.rng.random() < 0.1:
            terms = [f"ATAN[{self.value(depth)}]/[{self.value(depth)} + 0.001]"]
        for _ in range(self.rng.randint(0, 1)):
            sign = self.rng.choice(["+", " - ", "*", "/", " MOD ", "**"])
            term = self.value(depth)
            if sign in ("/", " MOD "):
                term = f"{self.rng.uniform(1, 5):.2f}"
            elif sign == "**":
                term, terms[-1] = str(self.rng.randint(0, 2)), f"[{terms[-1]}]"
            elif sign == "*":
                term = f"SIN[{term}]"
            terms += [sign, term]
        return "".join(terms)

    def block(self) -> str:
        """An assignment, or a move whose coordinates stay within a metre."""
        if self.rng.random() < 0.4:
            name = self.rng.choice([*self.names, f"#{self.rng.randint(2, 30)}", f"#<a{self.rng.randint(1, 3)}>"])
            text = f"{name} = [9 * SIN[{self.formula(0)}]]"
            self.names = [*self.names, *([] if name in self.names else [name])]
            return self.rng.choice([text, text.lower()])
        words = [f"{axis}[50 * SIN[{self.formula(0)}]]" for axis in "XYZ" if self.rng.random() < 0.7]
        words = words or [f"X{self.rng.choice(self.names)}"]
        return " ".join([self.rng.choice(["G0", "G1", "g1"]), *words])
