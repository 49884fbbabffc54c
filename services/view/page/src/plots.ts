/// Plots of the last minute, which scroll with time.
import uPlot from "uplot";
import type { CellMessage, StatusMessage } from "./protocol";
import { armColour } from "./figures";
import { clockText } from "./words";

const SPAN = 60; // [s]
const GAP = 5; // without values longer than this a line is interrupted [s]
const MOST_LINES = 8; // with more arms a plot shows the extreme of all

interface Plot {
  caption: string;
  values: (status: StatusMessage, age: (arm: string) => number) => (number | null)[];
  chart: uPlot;
  data: [number[], ...(number | null)[][]];
}

export class Plots {
  private plots: Plot[] = [];
  private dark = true;
  private cell: CellMessage | null = null;
  private drawnAt = 0;

  constructor(private readonly host: HTMLElement) {
    new ResizeObserver(() => this.resize()).observe(host);
  }

  setTheme(dark: boolean): void {
    this.dark = dark;
    if (!this.cell) return;
    const data = this.plots.map((plot) => plot.data);
    this.setCell(this.cell);
    this.plots.forEach((plot, i) => (plot.data = data[i]));
  }

  setCell(cell: CellMessage): void {
    this.cell = cell;
    for (const plot of this.plots) plot.chart.destroy();
    this.host.replaceChildren();
    const single = cell.arms.length > MOST_LINES;
    const names = cell.arms.map((arm) => arm.name);
    const lines = single ? ["all arms"] : names;
    const security = Math.min(...cell.arms.map((arm) => arm.security_distance));
    const extreme = (values: (number | null)[], pick: (...values: number[]) => number): (number | null)[] => {
      if (!single) return values;
      const known = values.filter((value): value is number => value !== null);
      return [known.length ? pick(...known) : null];
    };
    this.plots = [
      this.plot(`binding pair [mm], safe ${Math.round(security * 1000)}`, lines, (status) =>
        extreme(status.arms.map(({ goal }) => (goal && !goal.final && goal.binding
          ? goal.binding.distance * 1000 : null)), Math.min)),
      this.plot("fastest joint [rad/s]", lines, (status) =>
        extreme(status.arms.map((arm) => arm.speed ?? null), Math.max)),
      this.plot("tick, p99 [µs]", lines, (status) =>
        extreme(status.arms.map((arm) => status.nodes.find((node) => node.name === arm.planner)?.tick[1] ?? null),
                Math.max)),
      this.plot("oldest input [ms]", lines, (status) =>
        extreme(status.arms.map((arm) => {
          const node = status.nodes.find((candidate) => candidate.name === arm.planner);
          return node && node.input_age >= 0 ? node.input_age * 1000 : null;
        }), Math.max)),
    ];
    this.resize();
  }

  add(status: StatusMessage, age: (arm: string) => number): void {
    const now = status.wall / 1000;
    for (const plot of this.plots) {
      const times = plot.data[0];
      // A replay goes back, or on by leaps.
      while (times.length && times[times.length - 1] >= now) plot.data.forEach((column) => column.pop());
      if (times.length && now - times[times.length - 1] > GAP) {
        times.push(times[times.length - 1] + 1e-3);
        const lines: (number | null)[][] = plot.data.slice(1);
        lines.forEach((column) => column.push(null));
      }
      plot.data[0].push(now);
      const columns: (number | null)[][] = plot.data;
      plot.values(status, age).forEach((value, i) => columns[i + 1]?.push(value));
      while (plot.data[0][0] < now - SPAN) plot.data.forEach((column) => column.shift());
    }
    // People see no more than two new points a second, and drawing costs more than collecting.
    if (Math.abs(now - this.drawnAt) < 0.45) return;
    this.drawnAt = now;
    for (const plot of this.plots) {
      plot.chart.setData(plot.data, false);
      plot.chart.setScale("x", { min: now - SPAN, max: now });
    }
  }

  private plot(caption: string, lines: string[], values: Plot["values"]): Plot {
    const figure = document.createElement("figure");
    const text = document.createElement("figcaption");
    text.textContent = text.title = caption;
    figure.append(text);
    this.host.append(figure);
    const ink = this.dark ? "#8b939b" : "#656d75";
    const rule = this.dark ? "#2c3238" : "#d5d9dd";
    const axis: uPlot.Axis = { stroke: ink, grid: { stroke: rule, width: 1 }, ticks: { show: false }, font: "11px system-ui" };
    const options: uPlot.Options = {
      width: 200, height: 140, legend: { show: false }, cursor: { show: false },
      scales: { x: { time: true }, y: { range: (_chart, least, most) => [Math.min(0, least ?? 0), (most ?? 0) > 0 ? (most ?? 0) * 1.1 : 1] } },
      axes: [{ ...axis, size: 22, space: 70, values: (_chart, ticks) => ticks.map((t) => clockText(t * 1000)) }, { ...axis, size: 44 }],
      series: [{}, ...lines.map((label, i) => ({
        label, stroke: lines.length === 1 ? ink : `#${armColour(i).getHexString()}`, width: 1.5, spanGaps: false,
        points: { show: false },
      }))],
    };
    const data: Plot["data"] = [[], ...lines.map(() => [] as (number | null)[])];
    return { caption, values, chart: new uPlot(options, data, figure), data };
  }

  private resize(): void {
    for (const { chart } of this.plots) {
      const figure = chart.root.parentElement;
      if (figure && figure.clientWidth > 0) {
        chart.setSize({ width: figure.clientWidth - 8, height: Math.max(60, figure.clientHeight - 26) });
      }
    }
  }
}
