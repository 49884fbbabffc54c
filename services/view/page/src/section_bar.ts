/// The controls of a section: a button for its axis, and a slider for its place.
import { nextAxis } from "./section";
import type { CellScene } from "./scene";

const STEP = 0.02; // of a key [m]

export class SectionBar {
  private readonly axis = document.createElement("button");
  private readonly slider = document.createElement("input");
  private readonly place = document.createElement("output");

  constructor(host: HTMLElement, private readonly scene: CellScene) {
    this.axis.title = "Section across x, y, z or none (X)";
    this.axis.onclick = () => this.turn();
    this.slider.type = "range";
    this.slider.step = "0.01";
    this.slider.setAttribute("aria-label", "Place of the section");
    this.slider.title = "Place of the section (← →)";
    this.slider.oninput = () => this.move(Number(this.slider.value));
    this.place.className = "number";
    host.append(this.axis, this.slider, this.place);
    this.show();
  }

  /** The next axis, through the middle of the arms. */
  turn(): void {
    const axis = nextAxis(this.scene.section.axis);
    this.scene.cut(axis);
    if (axis !== null) {
      const [low, high] = this.scene.extent(axis);
      [this.slider.min, this.slider.max] = [low.toFixed(2), high.toFixed(2)];
    }
    this.show();
  }
  /** By a key: one step along the axis, or back. */
  step(by: 1 | -1): void {
    if (this.scene.section.axis === null) return;
    this.move(Math.min(Number(this.slider.max), Math.max(Number(this.slider.min), this.scene.section.at + by * STEP)));
  }

  private move(at: number): void {
    this.scene.section.move(at);
    this.show();
  }
  private show(): void {
    const { axis, at } = this.scene.section;
    this.axis.textContent = axis === null ? "Section" : `Section ${axis}`;
    this.axis.setAttribute("aria-pressed", String(axis !== null));
    this.slider.hidden = this.place.hidden = axis === null;
    this.slider.value = String(at);
    this.place.textContent = `${at.toFixed(2)} m`;
  }
}
