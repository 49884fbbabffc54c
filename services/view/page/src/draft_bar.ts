/// The bar over the scene while a goal is dragged: what is known about it, and the button that makes it an order.
import type { GoalDraft } from "./goal_draft";

export class DraftBar {
  /** The dragged goal shall become an order. */
  onGo: () => void = () => {};
  onRotate: () => void = () => {};
  private readonly text = document.createElement("span");
  private readonly rotate: HTMLButtonElement;
  private readonly go: HTMLButtonElement;

  constructor(private readonly host: HTMLElement, private readonly draft: GoalDraft) {
    this.text.id = "drafttext";
    this.text.setAttribute("role", "status");
    host.append(this.text);
    this.rotate = this.button("Rotate", "The gizmo rotates or moves (R)", () => this.onRotate());
    this.go = this.button("Go there", "The arm goes to its ghost (Enter)", () => this.onGo());
    this.go.id = "gothere";
    this.button("Cancel", "Ends the drag; nothing is sent (D)", () => draft.cancel());
    this.show();
  }

  show(): void {
    const { draft } = this;
    this.host.hidden = draft.arm === null;
    if (this.text.textContent !== draft.sentence) this.text.textContent = draft.sentence;
    this.text.dataset.state = draft.blocked ? "fault" : draft.near ? "waiting" : "";
    this.go.disabled = !draft.mayGo;
  }
  setRotation(rotates: boolean): void {
    this.rotate.setAttribute("aria-pressed", String(rotates));
  }

  private button(text: string, title: string, press: () => void): HTMLButtonElement {
    const made = document.createElement("button");
    made.textContent = text;
    made.title = title;
    made.onclick = press;
    this.host.append(made);
    return made;
  }
}
