"""Draws the figures of the design notes as SVG files, from the formulas that the notes state.

usage: design_figures.py [--check] [FOLDER]     FOLDER: where the files are; without it, beside this script

With --check it writes nothing and exits with 1 when a file differs.
"""
import math
import pathlib
import sys

INK, GREY = "#222222", "#777777"
BLUE, RED, GREEN, ORANGE = "#1f5fae", "#c03028", "#2f8f4f", "#d8862a"


class Figure:
    """A plot with axes in user units, equally scaled if `height` is None."""

    LEFT, TOP, RIGHT, BOTTOM = 62, 16, 16, 46

    def __init__(self, title, x, y, x_label, y_label, width=560, height=None, legend=(0, 0)):
        self.title, self.x, self.y, self.legend_at = title, x, y, legend
        self.scale_x = (width - self.LEFT - self.RIGHT) / (x[1] - x[0])
        self.scale_y = (height - self.TOP - self.BOTTOM) / (y[1] - y[0]) if height else self.scale_x
        self.width, self.height = width, height or round(self.TOP + self.BOTTOM + self.scale_y * (y[1] - y[0]))
        self.x_label, self.y_label = x_label, y_label
        self.parts, self.legend, self.clips = [], [], []

    def at(self, x, y):
        return self.LEFT + (x - self.x[0]) * self.scale_x, self.height - self.BOTTOM - (y - self.y[0]) * self.scale_y

    def _points(self, points):
        return " ".join("{:.1f},{:.1f}".format(*self.at(*point)) for point in points)

    def line(self, points, colour=INK, width=1.6, dash="", name=""):
        style = f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(f'<polyline points="{self._points(points)}" fill="none" stroke="{colour}" stroke-width="{width}"{style}/>')
        if name:
            self.legend.append((colour, width, dash, 1, name))

    def area(self, points, fill, stroke="none", opacity=0.5, name="", clip=""):
        inside = f' clip-path="url(#{clip})"' if clip else ""
        self.parts.append(f'<polygon points="{self._points(points)}" fill="{fill}" fill-opacity="{opacity}" stroke="{stroke}"{inside}/>')
        if name:
            self.legend.append((fill, 9, "", opacity, name))

    def arrow(self, begin, end, colour=INK):
        (x, y), (u, v) = self.at(*begin), self.at(*end)
        turn = math.atan2(v - y, u - x)
        head = " ".join(f"{u - 8 * math.cos(turn + side):.1f},{v - 8 * math.sin(turn + side):.1f}" for side in (0.4, -0.4))
        self.parts.append(f'<path d="M{x:.1f},{y:.1f} L{u:.1f},{v:.1f}" stroke="{colour}" stroke-width="1.6"/>'
                          f'<polygon points="{u:.1f},{v:.1f} {head}" fill="{colour}"/>')

    def text(self, x, y, words, colour=INK, anchor="start", dx=0, dy=0):
        u, v = self.at(x, y)
        self.parts.append(f'<text x="{u + dx:.1f}" y="{v + dy:.1f}" fill="{colour}" text-anchor="{anchor}">{words}</text>')

    def _axis(self):
        bottom, top = self.height - self.BOTTOM, self.TOP
        out = [f'<rect x="{self.LEFT}" y="{top}" width="{self.width - self.LEFT - self.RIGHT}" height="{bottom - top}" '
               f'fill="none" stroke="{INK}"/>']
        for value in ticks(*self.x):
            u = self.at(value, self.y[0])[0]
            out.append(f'<path d="M{u:.1f},{bottom} v5" stroke="{INK}"/><text x="{u:.1f}" y="{bottom + 18}" text-anchor="middle">{value:g}</text>')
        for value in ticks(*self.y):
            v = self.at(self.x[0], value)[1]
            out.append(f'<path d="M{self.LEFT},{v:.1f} h-5" stroke="{INK}"/><text x="{self.LEFT - 8}" y="{v + 4:.1f}" text-anchor="end">{value:g}</text>')
        middle = (bottom + top) / 2
        out.append(f'<text x="{(self.width + self.LEFT - self.RIGHT) / 2:.0f}" y="{self.height - 8}" text-anchor="middle">{self.x_label}</text>')
        out.append(f'<text transform="translate(15,{middle:.0f}) rotate(-90)" text-anchor="middle">{self.y_label}</text>')
        return out

    def _legend(self):
        left, top = self.LEFT + 4 + self.legend_at[0], self.TOP + 4 + self.legend_at[1]
        widest = max((len(row[-1]) for row in self.legend), default=0)
        rows = [f'<rect x="{left}" y="{top}" width="{50 + 6.4 * widest:.0f}" height="{8 + 18 * len(self.legend)}" fill="white" fill-opacity="0.9"/>']
        for i, (colour, width, dash, opacity, name) in enumerate(self.legend):
            y = top + 16 + 18 * i
            style = f' stroke-dasharray="{dash}"' if dash else ""
            rows.append(f'<path d="M{left + 8},{y - 4} h26" stroke="{colour}" stroke-width="{width}" stroke-opacity="{opacity}"{style}/>'
                        f'<text x="{left + 42}" y="{y}">{name}</text>')
        return rows

    def svg(self):
        clips = "".join(f'<clipPath id="{name}"><polygon points="{self._points(points)}"/></clipPath>' for name, points in self.clips)
        frame = [("frame", [(self.x[0], self.y[0]), (self.x[1], self.y[0]), (self.x[1], self.y[1]), (self.x[0], self.y[1])])]
        clips += "".join(f'<clipPath id="{name}"><polygon points="{self._points(points)}"/></clipPath>' for name, points in frame)
        body = ["<g clip-path=\"url(#frame)\">", *self.parts, "</g>", *self._axis(), *self._legend()]
        return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{self.width}" height="{self.height}" viewBox="0 0 {self.width} {self.height}" '
                f'font-family="sans-serif" font-size="12" fill="{INK}">\n<title>{self.title}</title>\n'
                f'<rect width="100%" height="100%" fill="white"/>\n<defs>{clips}</defs>\n' + "\n".join(body) + "\n</svg>\n")


def ticks(low, high):
    step = 10 ** math.floor(math.log10((high - low) / 2))
    step = next(step * factor for factor in (1, 2, 5, 10) if (high - low) / (step * factor) <= 8)
    first = math.ceil(low / step - 1e-9)
    return [round(step * i, 10) for i in range(first, math.floor(high / step + 1e-9) + 1)]


def spaced(low, high, count=200):
    return [low + (high - low) * i / (count - 1) for i in range(count)]


def circle(x, y, radius, begin=0.0, end=2 * math.pi):
    return [(x + radius * math.cos(t), y + radius * math.sin(t)) for t in spaced(begin, end, 60)]


def hull(points):
    """Convex, counter-clockwise."""
    def half(ordered):
        chain = []
        for p in ordered:
            while len(chain) > 1 and cross(chain[-2], chain[-1], p) <= 0:
                chain.pop()
            chain.append(p)
        return chain[:-1]
    ordered = sorted(points)
    return half(ordered) + half(ordered[::-1])


def cross(a, b, c):
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


# The damper of deploy/cells/three_puma.yaml: ξ [m/s], dᵢ, dₛ [m].
SPEED, INFLUENCE, SECURITY = 0.55, 0.12, 0.03


def allowed(distance, response):
    x, shortest = distance - SECURITY, (INFLUENCE - SECURITY) / SPEED
    return x / min(max(x / SPEED, shortest), max(shortest, response))


def damper():
    figure = Figure("Allowed approach speed against distance", (0, 0.4), (-0.2, 1.2), "distance d [m]", "allowed approach speed f(d − dₛ) [m/s]", height=340, legend=(150, 190))
    for x, name in ((SECURITY, "dₛ"), (INFLUENCE, "dᵢ")):
        figure.line([(x, -0.2), (x, 1.2)], GREY, 1, "4 3")
        figure.text(x, 1.2, name, GREY, dx=4, dy=14)
    figure.line([(0, 0), (0.4, 0)], GREY, 0.8)
    figure.line([(0, SPEED), (0.4, SPEED)], GREY, 1, "4 3")
    figure.text(0, SPEED, "ξ", GREY, dx=4, dy=-5)
    for speed, colour in ((1.5, GREEN), (3, BLUE), (6, RED)):
        response = speed / 10 + 0.01
        figure.line([(d, allowed(d, response)) for d in spaced(0, 0.4)], colour, name=f"{speed:g} rad/s, 10 rad/s²: T_max + dt = {response:.2f} s")
    figure.line([(0, allowed(0, 0)), (INFLUENCE, allowed(INFLUENCE, 0))], INK, 3.5, name="the paper, within dᵢ")
    return figure


def latency():
    figure = Figure("Least possible distance of an arm whose state is old", (0, 0.3), (0, 0.3), "expected distance d [m]",
                    "least possible distance L [m]", height=380, legend=(40, 20))
    slope, acceleration = SPEED / (INFLUENCE - SECURITY), 6.0
    figure.line([(SECURITY, 0), (SECURITY, 0.3)], GREY, 1, "4 3")
    figure.text(SECURITY, 0.3, "dₛ", GREY, dx=4, dy=14)
    figure.line([(0, 0), (0.3, 0.3)], INK, 1, name="age 0: L = d")
    for age, colour in ((0.05, GREEN), (0.1, BLUE), (0.2, RED)):
        def least(d):
            by_acceleration = d - 0.5 * acceleration * age**2
            by_damper = SECURITY + (d - SECURITY) * math.exp(-0.5 * slope * age)
            return min(d, max(by_acceleration, by_damper))
        figure.line([(d, least(d)) for d in spaced(SECURITY, 0.3)], colour, 2, name=f"age {1000 * age:.0f} ms: L")
        figure.line([(d, d - 0.5 * acceleration * age**2) for d in spaced(0, 0.3)], colour, 1, "2 3")
    figure.line([(-1, -1), (-1, -1)], GREY, 1, "2 3", name="L_a alone (a = 6 m/s²)")
    return figure


def stop_set():
    """A planar arm of two links, last heard at (q, q̇); both joints with the limits of note 9."""
    links, q, rate, moved_for, most, acceleration = (0.45, 0.4), (0.35, 0.9), (0.6, -0.3), 0.11, 1.5, 10.0
    stop = max(min(most, abs(v) + acceleration * moved_for) for v in rate) / acceleration

    def farthest(v):
        fastest = min(most, v + acceleration * moved_for)
        speeding = (fastest - v) / acceleration
        return 0.5 * (v + fastest) * speeding + fastest * (moved_for - speeding) + 0.5 * max(0, fastest) * stop

    up, down = [p + farthest(v) for p, v in zip(q, rate)], [p - farthest(-v) for p, v in zip(q, rate)]
    centre, half = [(a + b) / 2 for a, b in zip(up, down)], [(a - b) / 2 for a, b in zip(up, down)]

    def joints(a, b):
        elbow = (links[0] * math.cos(a), links[0] * math.sin(a))
        return [(0, 0), elbow, (elbow[0] + links[1] * math.cos(a + b), elbow[1] + links[1] * math.sin(a + b))]

    figure = Figure("The reachable stop set of a two-link arm", (-0.1, 1.1), (-0.1, 1.0), "x [m]", "y [m]", width=520)
    elbow, tip = joints(*centre)[1:]
    uncertainty = sum(links) * half[0] + links[1] * half[1]
    figure.area(hull(circle(*elbow, uncertainty) + circle(*tip, uncertainty)), RED, RED, 0.12, name="forearm at the centre, grown by σ = Σ lⱼ sⱼ")
    for i in range(5):
        for j in range(5):
            figure.line(joints(down[0] + 2 * half[0] * i / 4, down[1] + 2 * half[1] * j / 4), GREY, 0.7)
    figure.line([(-1, -1), (-1, -1)], GREY, 0.7, name="arms in the box of the set")
    figure.line(joints(*q), BLUE, 3, name="last heard (q, q̇)")
    figure.line(joints(*centre), ORANGE, 3, name="centre of the set")
    return figure


def passing():
    figure = Figure("The swept volume of an obstacle that passes", (-0.15, 0.55), (-0.25, 0.35), "x [m]", "y [m]", width=560, legend=(4, 322))
    ball, speed, time, acceleration, age = 0.06, 1.5, (INFLUENCE - SECURITY) / SPEED, 2.0, 0.02
    begin, end = ball + 0.5 * acceleration * age**2, ball + 0.5 * acceleration * (age + time)**2
    way = speed * time
    volume = hull(circle(0, 0, begin) + circle(way, 0, end))
    figure.area(volume, ORANGE, ORANGE, 0.25, name="C: where the obstacle can be within S")
    figure.area(circle(0, 0, ball), ORANGE, INK, 0.9, name="obstacle now, velocity v")
    body = hull(circle(0.14, 0.19, 0.04) + circle(0.3, 0.3, 0.04))
    figure.area(body, BLUE, INK, 0.5, name="body of the arm")
    figure.arrow((0, 0), (way, 0), INK)
    figure.text(way, 0, "v S", dx=-20, dy=-6)
    # The nearest points of C's upper side and the arm's lower ball.
    turn = math.asin((end - begin) / way)
    normal = (-math.sin(turn), math.cos(turn))
    along = (0.14 * math.cos(turn) + 0.19 * math.sin(turn))
    point = (along * math.cos(turn) + begin * normal[0], along * math.sin(turn) + begin * normal[1])
    own = (0.14 - 0.04 * normal[0], 0.19 - 0.04 * normal[1])
    side = (math.cos(turn), math.sin(turn))
    figure.line([tuple(a + step * b for a, b in zip(own, side)) for step in (-0.5, 0.6)], GREEN, 1.4, "6 4", name="separating plane")
    figure.arrow(own, point, RED)
    figure.text((own[0] + point[0]) / 2, (own[1] + point[1]) / 2, "d_C, n_C", RED, dx=8, dy=4)
    return figure


def cspace_interval():
    """In lengths of the second link; its base, the elbow e, is at the origin."""
    figure = Figure("Directions in which a link touches an obstacle", (-0.35, 1.45), (-0.2, 1.5), "x / l₂", "y / l₂", width=520)
    width, corners = 0.12, [(0.62, 0.42), (1.2, 0.62), (0.78, 0.95)]
    grown = hull([p for corner in corners for p in circle(*corner, width)])
    disc = circle(0, 0, 1)
    figure.clips.append(("disc", disc))
    figure.line(disc, GREY, 1.2, "5 3", name="D: reach of the second link")
    figure.line(grown + grown[:1], BLUE, 1.2, name="O ⊕ w")
    figure.area(grown, BLUE, "none", 0.25, name="K = (O ⊕ w) ∩ D", clip="disc")
    figure.area(corners, INK, INK, 0.5, name="obstacle O")
    # K's extreme directions: of the grown outline within the disc, finely sampled.
    fine = [tuple(a + (b - a) * i / 40 for a, b in zip(p, q)) for p, q in zip(grown, grown[1:] + grown[:1]) for i in range(40)]
    angles = [math.atan2(y, x) for x, y in fine if math.hypot(x, y) <= 1]
    for angle in (min(angles), max(angles)):
        figure.line([(0, 0), (1.12 * math.cos(angle), 1.12 * math.sin(angle))], RED, 1.6)
    figure.line([(-9, -9), (-9, -9)], RED, 1.6, name="ends of the interval of θ₂")
    figure.area(circle(0, 0, 0.02), INK, INK, 1)
    figure.text(0, 0, "e", dx=-14, dy=12)
    return figure


FIGURES = {"damper": damper, "latency": latency, "stop-set": stop_set, "passing": passing, "cspace-interval": cspace_interval}


def main(arguments):
    check = "--check" in arguments
    places = [argument for argument in arguments if argument != "--check"]
    folder = pathlib.Path(places[0] if places else pathlib.Path(__file__).parent)
    stale = []
    for name, draw in FIGURES.items():
        file, picture = folder / f"{name}.svg", draw().svg()
        if not check:
            file.write_text(picture, encoding="utf-8")
        elif not file.exists() or file.read_text(encoding="utf-8") != picture:
            stale.append(f"{file} is not what this script draws: run {__file__}")
    print("\n".join(stale) or f"{len(FIGURES)} figures {'are as drawn' if check else 'drawn'}")
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
