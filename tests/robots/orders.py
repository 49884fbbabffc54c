"""Lines that order something of a simulated controller: the methods of a class, and words for their arguments."""
import inspect


def listed(orders):
    """One line for each order, for --help."""
    lines = []
    for name, method in inspect.getmembers(orders, inspect.isfunction):
        words = [f"{word.name.upper()}…" if word.kind is word.VAR_POSITIONAL else word.name.upper()
                 for word in list(inspect.signature(method).parameters.values())[1:]]
        meaning = (method.__doc__ or "").strip().split("\n")[0]
        lines.append("  " + " ".join([name, *words]) + (f": {meaning}" if meaning else ""))
    return ("orders:\n" + "\n".join(lines)).replace("%", "%%")


def obey(orders, controller, line):
    """What the order of that line returns. An order that does not exist, or has other words, changes nothing."""
    try:
        name, *words = line.decode().split() or [""]
        method = inspect.getattr_static(orders, name, None)
        if not isinstance(method, staticmethod):
            return {"error": f"'{name}' is no order; --help lists them"}
        inspect.signature(getattr(orders, name)).bind(controller, *words)
        return getattr(orders, name)(controller, *words)
    except (TypeError, ValueError, LookupError) as error:
        return {"error": f"'{line.decode(errors='replace')}': {error}"}
