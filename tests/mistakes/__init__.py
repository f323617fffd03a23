"""A hundred mistakes of users, and what happens: `python -m tests.mistakes` makes docs/mistakes.md of them."""
