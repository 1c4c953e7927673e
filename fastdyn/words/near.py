"""Names that may be meant by a wrong one: the one way to find them, for Python and command line."""

import difflib

ALIKE = 0.6  # least likeness of a name that may be meant
MOST = 3  # names in a proposal
SHORTEST = 3  # letters of a word that is looked for within names


def plain(name):
    """A name without cases and the signs between its words."""
    return name.lower().replace("_", "").replace("-", "").replace(" ", "")


def near_names(word, known, others=None, alike=ALIKE):
    """The names of `known` that a word may stand for, at most three; [] if none is near.

    Cases and signs between words do not count.  Next come `others`, words of other packages with
    our names, then beginnings, then parts of names, then likeness.
    """
    if not isinstance(word, str):
        return []
    names = {plain(each): each for each in known}
    word = plain(word)
    if word in names:
        return [names[word]]
    meant = {plain(each): own for each, own in (others or {}).items()}
    if meant.get(word) in known:
        return [meant[word]]
    if len(word) >= SHORTEST:
        begun = [each for key, each in names.items() if key.startswith(word)]
        if begun:
            return begun[:MOST]
        found = [each for key, each in names.items() if word in key]
        if 0 < len(found) <= MOST:
            return found
    return [names[key] for key in difflib.get_close_matches(word, names, n=1, cutoff=alike)]


def did_you_mean(word, known, others=None, form="`{}`", alike=ALIKE):
    """A question, "did you mean `rtol`?", or "" if no name is near."""
    *first, last = [form.format(each) for each in near_names(word, known, others, alike)] or [""]
    return last and f"did you mean {', '.join(first)}{' or ' if first else ''}{last}?"
