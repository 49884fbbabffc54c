"""Draws one moment of a recorded episode as an SVG: arms, obstacles, paths of the tools.

usage: draw_episode.py --moment SECONDS --title TEXT < EPISODE > PICTURE.svg

EPISODE: a file of `hecaton simulate CELL --record EPISODE`, for example:

    build/release/bin/hecaton simulate deploy/cells/three_puma.yaml --tasks 3 --seed 4 --record episode.jsonl
    python3 docs/figures/draw_episode.py --moment 1.5 --title "Three arms exchange places, each with a planner of its own" \\
        < episode.jsonl > three-arms.svg

Needs nothing but Python. The view is orthographic, so that the outline of a capsule is exact."""
import argparse
import json
import math
import sys

AZIMUTH, ELEVATION = math.radians(-153), math.radians(27)  # of the viewer, seen from the origin of W
SCALE = 310.0  # [px/m]
WIDTH, HEIGHT = 1080, 760
ORIGIN = (510, 552)  # where the origin of W is drawn [px]
FLOOR = 1.0  # half an edge of the floor [m]
COLOURS = {0: ("#9cc8f0", "#2f76b8", "#12395f"), 1: ("#ffd49a", "#e08a1e", "#7a430a"), 2: ("#a9e0b4", "#35975a", "#12492a")}
OBSTACLE = ("#dcd8e6", "#8d86a3", "#4a445c")
FONT = "font-family='DejaVu Sans, Verdana, sans-serif'"

cos_a, sin_a, cos_e, sin_e = math.cos(AZIMUTH), math.sin(AZIMUTH), math.cos(ELEVATION), math.sin(ELEVATION)
RIGHT = (-sin_a, cos_a, 0.0)
UP = (-sin_e * cos_a, -sin_e * sin_a, cos_e)
TOWARDS = (cos_e * cos_a, cos_e * sin_a, sin_e)  # the viewer


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def pixel(p):
    return ORIGIN[0] + SCALE * dot(RIGHT, p), ORIGIN[1] - SCALE * dot(UP, p)


def between(a, b, share):
    return [x + share * (y - x) for x, y in zip(a, b)]


def points(places):
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in places)


def mixed(colour, other, share):
    channels = [(int(colour[i:i + 2], 16), int(other[i:i + 2], 16)) for i in (1, 3, 5)]
    return "#" + "".join(f"{round(a + share * (b - a)):02x}" for a, b in channels)


class Picture:
    def __init__(self):
        self._definitions = {}
        self._parts = []

    def define(self, text):
        """The id of a gradient with this text."""
        return self._definitions.setdefault(text, f"g{len(self._definitions)}")

    def add(self, text):
        self._parts.append(text)

    def svg(self):
        gradients = "\n".join(text.replace("ID", name, 1) for text, name in self._definitions.items())
        return (f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {WIDTH} {HEIGHT}' {FONT}>\n<defs>\n{gradients}\n"
                f"<marker id='arrow' viewBox='0 0 8 8' refX='6' refY='4' markerWidth='7' markerHeight='7' "
                f"orient='auto-start-reverse'><path d='M0,0.5L7,4L0,7.5z' fill='{OBSTACLE[2]}'/></marker>\n"
                f"</defs>\n<rect width='{WIDTH}' height='{HEIGHT}' fill='white'/>\n" + "\n".join(self._parts) + "\n</svg>\n")


def stops(colours):
    light, base, dark = colours
    return (f"<stop offset='0' stop-color='{light}'/><stop offset='.35' stop-color='{mixed(light, base, .55)}'/>"
            f"<stop offset='.75' stop-color='{base}'/><stop offset='1' stop-color='{dark}'/>")


def ball(picture, centre, radius, colours):
    """(depth, SVG) of a shaded ball."""
    x, y = pixel(centre)
    shade = picture.define(f"<radialGradient id='ID'>{stops(colours)}</radialGradient>")
    return dot(TOWARDS, centre), f"<circle cx='{x:.1f}' cy='{y:.1f}' r='{SCALE * radius:.1f}' fill='url(#{shade})'/>"


def tube(picture, start, end, radius, colours):
    """Pieces of a round bar without its ends; short, so that each has about one depth."""
    (x0, y0), (x1, y1) = pixel(start), pixel(end)
    length = math.hypot(x1 - x0, y1 - y0)
    if length < 0.5:
        return
    across = ((y1 - y0) / length * SCALE * radius, -(x1 - x0) / length * SCALE * radius)
    shade = picture.define(
        f"<linearGradient id='ID' gradientUnits='userSpaceOnUse' spreadMethod='reflect' x1='{x0:.1f}' y1='{y0:.1f}' "
        f"x2='{x0 + across[0]:.1f}' y2='{y0 + across[1]:.1f}'>{stops(colours)}</linearGradient>")
    count = max(1, round(math.dist(start, end) / 0.12))
    overlap = 1.1 * count / length  # [px] of the next piece, or seams would show
    for i in range(count):
        a, b = between(start, end, i / count), between(start, end, (i + 1) / count)
        middle = between(a, b, 0.5)
        (ax, ay), (bx, by) = pixel(a), pixel(between(a, b, 1.0 + overlap if i + 1 < count else 1.0))
        corners = [(ax + across[0], ay + across[1]), (bx + across[0], by + across[1]),
                   (bx - across[0], by - across[1]), (ax - across[0], ay - across[1])]
        yield dot(TOWARDS, middle), f"<polygon points='{points(corners)}' fill='url(#{shade})'/>"


def box(corners, colours):
    """The three faces that the viewer sees."""
    centre = [sum(c[i] for c in corners) / 8 for i in range(3)]
    for axis, brightness in ((0, 0.75), (1, 0.45), (2, 0.0)):
        for side in (0, 1):
            face = [corner for i, corner in enumerate(corners) if (i >> axis & 1) == side]
            middle = [sum(c[i] for c in face) / 4 for i in range(3)]
            if dot(TOWARDS, middle) <= dot(TOWARDS, centre):
                continue
            ordered = [face[0], face[1], face[3], face[2]]
            colour = mixed(colours[0], colours[1], brightness)
            yield (dot(TOWARDS, centre) + 0.001, f"<polygon points='{points(map(pixel, ordered))}' fill='{colour}' "
                   f"stroke='{colours[2]}' stroke-width='.7' stroke-linejoin='round'/>")


def disc(centre, radius):
    """The rim of a level disc."""
    return [[centre[0] + radius * math.cos(a * math.pi / 24), centre[1] + radius * math.sin(a * math.pi / 24), centre[2]]
            for a in range(48)]


def shape_parts(picture, shape, colours):
    if shape["kind"] == "box":
        yield from box(shape["corners"], colours)
        return
    if shape["kind"] == "convex":
        yield outline(shape["corners"], colours)
        return
    if shape["kind"] == "points":
        for centre in shape["centres"]:
            yield ball(picture, centre, shape["radius"], colours)
        return
    start, end, radius = shape["from"], shape["to"], shape["radius"]
    yield from tube(picture, start, end, radius, colours)
    if shape["kind"] == "capsule":
        yield ball(picture, start, radius, colours)
        yield ball(picture, end, radius, colours)
    else:
        top = max(start, end, key=lambda p: p[2])
        yield (dot(TOWARDS, top) + 0.01, f"<polygon points='{points(map(pixel, disc(top, radius)))}' "
               f"fill='{colours[0]}' stroke='{colours[2]}' stroke-width='.7'/>")


def hull(places):
    """Of points in a plane, counter-clockwise."""
    places = sorted(set(places))

    def half(ordered):
        chain = []
        for p in ordered:
            while len(chain) > 1 and ((chain[-1][0] - chain[-2][0]) * (p[1] - chain[-2][1])
                                      <= (chain[-1][1] - chain[-2][1]) * (p[0] - chain[-2][0])):
                chain.pop()
            chain.append(p)
        return chain[:-1]

    return half(places) + half(places[::-1])


def outline(corners, colours):
    """The silhouette of a convex body."""
    depth = max(dot(TOWARDS, corner) for corner in corners)
    return (depth, f"<polygon points='{points(hull([pixel(corner) for corner in corners]))}' fill='{colours[1]}' "
            f"stroke='{colours[2]}' stroke-width='.7' stroke-linejoin='round'/>")


def shadow(shape):
    """On the floor, of light from above."""
    edge = shape.get("corners") or shape.get("centres") or disc(shape["from"], shape["radius"]) + disc(shape["to"], shape["radius"])
    return f"<polygon points='{points(hull([pixel([p[0], p[1], 0.0]) for p in edge]))}'/>"


def line(a, b, style):
    (x0, y0), (x1, y1) = pixel(a), pixel(b)
    return f"<line x1='{x0:.1f}' y1='{y0:.1f}' x2='{x1:.1f}' y2='{y1:.1f}' {style}/>"


def label(place, text, style="", dx=0, dy=0):
    x, y = pixel(place)
    return f"<text x='{x + dx:.1f}' y='{y + dy:.1f}' {style}>{text}</text>"


def floor(picture):
    corners = [(-FLOOR, -FLOOR, 0), (FLOOR, -FLOOR, 0), (FLOOR, FLOOR, 0), (-FLOOR, FLOOR, 0)]
    picture.add(f"<polygon points='{points(map(pixel, corners))}' fill='#f5f6f8' stroke='#b9bec7'/>")
    steps = [i / 4 for i in range(int(-4 * FLOOR), int(4 * FLOOR) + 1)]
    for s in steps:
        style = f"stroke='{'#d3d7de' if s % 0.5 == 0 else '#e7e9ed'}'"
        picture.add(line((s, -FLOOR, 0), (s, FLOOR, 0), style) + line((-FLOOR, s, 0), (FLOOR, s, 0), style))


def axes(picture):
    """Along the two edges of the floor that are nearest to the viewer, and up from its left corner."""
    near_x, near_y = math.copysign(FLOOR, cos_a), math.copysign(FLOOR, sin_a)
    ink = "stroke='#5b6270' stroke-width='1.2'"
    small = "font-size='14' fill='#3c424d' text-anchor='middle'"
    bold = "font-size='15' fill='#22262e' text-anchor='middle' font-style='italic'"
    for s in (-1.0, -0.5, 0.0, 0.5, 1.0):
        text = f"{s:g}".replace("-", "−")
        picture.add(line((s, near_y, 0), (s, 1.03 * near_y, 0), ink) + label((s, 1.1 * near_y, 0), text, small, dy=6))
        picture.add(line((near_x, s, 0), (1.03 * near_x, s, 0), ink) + label((1.1 * near_x, s, 0), text, small, dy=6))
    picture.add(line((-near_x, near_y, 0), (near_x, near_y, 0), ink) + line((near_x, -near_y, 0), (near_x, near_y, 0), ink))
    picture.add(label((0.25, 1.24 * near_y, 0), "x [m]", bold, dy=6) + label((1.24 * near_x, 0.25, 0), "y [m]", bold, dy=6))
    x, y = min(((near_x, -near_y), (-near_x, near_y)), key=lambda corner: pixel((*corner, 0))[0])
    picture.add(line((x, y, 0), (x, y, 1.55), ink) + label((x, y, 1.62), "z [m]", bold))
    for z in (0.5, 1.0, 1.5):
        px, py = pixel((x, y, z))
        picture.add(f"<line x1='{px - 7:.1f}' y1='{py:.1f}' x2='{px:.1f}' y2='{py:.1f}' {ink}/>"
                    f"<text x='{px - 11:.1f}' y='{py + 5:.1f}' font-size='14' fill='#3c424d' text-anchor='end'>{z:g}</text>")


def tool_path(picture, moments, arm, colours, interval):
    """Of the whole episode, with a dot at every interval."""
    places = [pixel(m["arms"][arm]["tool"]) for m in moments]
    picture.add(f"<polyline points='{points(places)}' fill='none' stroke='white' stroke-width='5' opacity='.7' "
                "stroke-linejoin='round'/>")
    picture.add(f"<polyline points='{points(places)}' fill='none' stroke='{colours[2]}' stroke-width='2.2' "
                "stroke-linejoin='round'/>")
    due = 0.0
    for moment, (x, y) in zip(moments, places):
        if moment["time"] >= due - 1e-9:
            due += interval
            picture.add(f"<circle cx='{x:.1f}' cy='{y:.1f}' r='3' fill='{colours[2]}' stroke='white' stroke-width='.8'/>")
    goal_mark(picture, pixel(moments[0]["arms"][arm]["goal"]), colours)


def goal_mark(picture, place, colours):
    x, y = place
    picture.add(f"<circle cx='{x:.1f}' cy='{y:.1f}' r='9' fill='white' fill-opacity='.85' stroke='{colours[2]}' "
                f"stroke-width='2.4'/><circle cx='{x:.1f}' cy='{y:.1f}' r='3.6' fill='{colours[1]}'/>")


def obstacle_path(picture, moments, index):
    """Where a moving obstacle goes during the episode."""
    def middle(moment):
        shape = moment["obstacles"][index]["shapes"][0]
        corners = shape.get("corners") or [shape["from"], shape["to"]]
        return [sum(c[i] for c in corners) / len(corners) for i in range(3)]

    places = [middle(m) for m in moments]
    if math.dist(places[0], places[-1]) > 0.02:
        picture.add(f"<polyline points='{points(map(pixel, places))}' fill='none' stroke='{OBSTACLE[2]}' "
                    "stroke-width='1.8' stroke-dasharray='5 4' marker-end='url(#arrow)'/>")


def legend(picture, moments, moment, title, interval):
    picture.add(f"<text x='24' y='38' font-size='21' fill='#16191f' font-weight='bold'>{title}</text>")
    picture.add(f"<text x='24' y='62' font-size='15' fill='#3c424d'>t = {moment['time']:.1f} s of "
                f"{moments[-1]['time']:.1f} s; faint: where the arms started</text>")
    x, y = WIDTH - 318, 30
    for arm, entry in enumerate(moment["arms"]):
        colours = COLOURS[arm % 3]
        shade = picture.define(f"<linearGradient id='ID' x1='0' y1='.5' x2='0' y2='1' spreadMethod='reflect'>"
                               f"{stops(colours)}</linearGradient>")
        picture.add(f"<rect x='{x}' y='{y - 7}' width='34' height='14' rx='7' fill='url(#{shade})'/>"
                    f"<text x='{x + 46}' y='{y + 5}' font-size='15' fill='#22262e'>arm {entry['name']}</text>")
        y += 25
    rows = ((f"<circle cx='{x + 17}' cy='0' r='8' fill='{OBSTACLE[1]}'/>", "obstacle"),
            (f"<line x1='{x}' y1='0' x2='{x + 30}' y2='0' stroke='{OBSTACLE[2]}' stroke-width='1.8' "
             "stroke-dasharray='5 4' marker-end='url(#arrow)'/>", "its path"),
            (f"<line x1='{x}' y1='0' x2='{x + 34}' y2='0' stroke='#2a2e36' stroke-width='2.2'/>" +
             "".join(f"<circle cx='{x + c}' cy='0' r='3' fill='#2a2e36'/>" for c in (5, 17, 29)),
             f"path of a tool, a dot every {interval:g} s"),
            (f"<circle cx='{x + 17}' cy='0' r='8' fill='white' stroke='#2a2e36' stroke-width='2.2'/>"
             f"<circle cx='{x + 17}' cy='0' r='3.4' fill='#2a2e36'/>", "goal of a tool"))
    for mark, text in rows:
        picture.add(f"<g transform='translate(0 {y})'>{mark}<text x='{x + 46}' y='5' font-size='15' "
                    f"fill='#22262e'>{text}</text></g>")
        y += 25


def draw(moments, instant, title, interval=0.25):
    moment = min(moments, key=lambda m: abs(m["time"] - instant))
    picture = Picture()
    floor(picture)
    shapes = [(shape, OBSTACLE) for obstacle in moment["obstacles"] for shape in obstacle["shapes"]]
    shapes += [(shape, COLOURS[i % 3]) for i, arm in enumerate(moment["arms"]) for shape in arm["shapes"]]
    picture.add("<g opacity='.13' fill='#101828'>" + "".join(shadow(shape) for shape, _ in shapes) + "</g>")
    axes(picture)
    for i, arm in enumerate(moments[0]["arms"]):
        parts = sorted((part for shape in arm["shapes"] for part in shape_parts(picture, shape, COLOURS[i % 3])))
        picture.add("<g opacity='.16'>" + "".join(text for _, text in parts) + "</g>")
    for index in range(len(moment["obstacles"])):
        obstacle_path(picture, moments, index)
    parts = sorted(part for shape, colours in shapes for part in shape_parts(picture, shape, colours))
    picture.add("\n".join(text for _, text in parts))
    for i in range(len(moment["arms"])):
        tool_path(picture, moments, i, COLOURS[i % 3], interval)
    legend(picture, moments, moment, title, interval)
    return picture.svg()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--moment", type=float, required=True, metavar="SECONDS", help="which moment is drawn")
    parser.add_argument("--title", required=True, metavar="TEXT")
    options = parser.parse_args()
    moments = [json.loads(text) for text in sys.stdin]
    sys.stdout.write(draw(moments, options.moment, options.title))


if __name__ == "__main__":
    main()
