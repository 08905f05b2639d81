// The display panel, and the labels in the viewport.
import { add_fact, checked, choose, element } from "../common/dom";
import { grouped, short_number } from "../common/numbers";
import { show_legend } from "./lists";
import { blocks_beside, blocks_for } from "./picture";
import type { Choice, Picture, ShownColour } from "./picture";
import type { BesideMessage, BodyMessage } from "./protocol";
import type { BlockName, FrameMessage } from "./wire";

// What this needs from the page.
export interface LookUser {
  command(type: string, members: object): Promise<string>;
  send(type: string, members: object): void;
  changed(): void;
  paints(): boolean;
  chooses_bones(): boolean;
  paint_legend(): [string, string | null][];
}

const is_on = (id: string) => element<HTMLInputElement>(id).checked;

function offer(value: string, is_there: boolean): void {
  const list = element<HTMLSelectElement>("colour");
  const option = list.querySelector<HTMLOptionElement>(`option[value="${value}"]`);
  if (!option) return;
  option.disabled = !is_there;
  if (!is_there && option.selected) list.value = "materials";
}

// The last folder of each path, or as much of the path as makes it unique.
export function short_names(names: readonly string[]): string[] {
  const parts = names.map((name) => name.split("/").filter((part) => part !== "" && part !== "."));
  return parts.map((own, k) => {
    for (let count = 1; count < own.length; ++count) {
      const short = own.slice(-count).join("/");
      if (parts.every((other, o) => o === k || other.slice(-count).join("/") !== short)) return short;
    }
    return names[k];
  });
}

// Whether to switch to both side by side: if the user chose another bake, but not if the same bake reappears
// because it was rewritten.
export function shows_sides(last: string, name: string, comparison: string): boolean {
  return name !== last && comparison === "flesh";
}

export class Look {
  private body: BodyMessage | null = null;
  private beside: BesideMessage | null = null;
  private last_beside = ""; // the previous comparison bake
  private blocks = "";
  private legend_shown = "";
  private seen = { frames: 0, since: 0, rate: 0 };

  constructor(
    private readonly picture: Picture,
    private readonly user: LookUser,
  ) {}

  choice(): Choice {
    const axis = element<HTMLSelectElement>("cut-axis").value;
    const paints = this.user.paints();
    const colour = paints ? "paint" : (element<HTMLSelectElement>("colour").value as ShownColour);
    // Muscles and contact are values of the model's own vertices.
    const of_model = checked("body") === "tetrahedra" || colour === "muscles" || colour === "contact" || axis !== "";
    const share = Number(element<HTMLInputElement>("lag-scale").value) / 100;
    return {
      colour,
      comparison: checked("comparison") as Choice["comparison"],
      against: this.beside?.bake ? "bake" : "skinning",
      tetrahedra: of_model && !paints,
      cut: axis === "" ? null : { axis: Number(axis) as 0 | 1 | 2, place: this.cut_place(Number(axis)) },
      edges: is_on("edges"),
      fibres: is_on("fibres"),
      skeleton: is_on("skeleton") || this.user.chooses_bones(),
      inverted: is_on("inverted"),
      solids: is_on("solids") && this.picture.overlays.has_solids,
      lag_scale: this.picture.scale_for(colour) * share,
    };
  }

  private cut_place(axis: number): number {
    if (!this.body) return 0;
    const [least, most] = this.body.bounds;
    const share = Number(element<HTMLInputElement>("cut").value) / 100;
    return least[axis] + share * (most[axis] - least[axis]);
  }

  ask_for_blocks(): void {
    const choice = this.choice();
    const blocks: BlockName[] = blocks_for(choice, this.picture.has_skin);
    const beside = this.picture.beside.is_there ? blocks_beside(choice, this.picture.beside.has_skin) : [];
    const key = `${blocks.join()} ${beside.join()}`;
    if (key === this.blocks) return;
    this.blocks = key;
    this.user.command("show", { blocks, beside }).catch(() => (this.blocks = ""));
  }

  // After a reconnect, the server no longer knows which blocks were requested.
  forget(): void {
    this.blocks = "";
  }

  // The legend is rebuilt the next time.
  mend_legend(): void {
    this.legend_shown = "";
  }

  // Called once the viewport shows this body.
  set_body(body: BodyMessage): void {
    this.body = body;
    const facts = element("facts");
    facts.replaceChildren();
    add_fact(facts, "Vertices", grouped(body.counts.vertices));
    add_fact(facts, "Tetrahedra", grouped(body.counts.tetrahedra));
    add_fact(facts, "Skin vertices", grouped(body.counts.surface_vertices));
    add_fact(facts, "Solver", "–");
    add_fact(facts, "Display", "–");
    if (body.solids.length > 0) add_fact(facts, "On solids", "–");
    offer("muscles", this.picture.has_muscles);
    const solids = element<HTMLInputElement>("solids");
    solids.disabled = body.solids.length === 0;
    solids.title = solids.disabled
      ? "This scene has no solids"
      : body.solids.map((one) => `${one.name}: ${one.shape}`).join(", ");
    const skin = document.querySelector<HTMLInputElement>('input[name="body"][value="skin"]');
    if (skin) skin.disabled = !this.picture.has_skin;
    if (!this.picture.has_skin) choose("body", "tetrahedra");
    this.offer_difference();
  }

  private offer_difference(): void {
    offer("difference", this.picture.is_like_beside(false) || this.picture.is_like_beside(true));
  }

  // Called once the viewport shows this comparison bake.
  set_beside(message: BesideMessage): void {
    this.beside = message;
    const list = element<HTMLSelectElement>("against");
    const names = message.choices;
    const short = short_names(names);
    list.replaceChildren(new Option("Skinning alone", ""));
    names.forEach((name, k) => {
      const option = new Option(short[k], name);
      option.title = name;
      list.add(option);
    });
    list.value = message.bake?.name ?? "";
    element("against-row").hidden = names.length === 0;
    this.offer_difference();
    if (message.bake) {
      if (shows_sides(this.last_beside, message.bake.name, checked("comparison"))) choose("comparison", "sides");
      this.last_beside = message.bake.name;
    }
    document.documentElement.dataset.beside = message.bake?.name ?? "";
  }

  get beside_name(): string {
    const at = this.beside?.choices.indexOf(this.beside.bake?.name ?? "") ?? -1;
    return at < 0 ? (this.beside?.bake?.name ?? "") : short_names(this.beside!.choices)[at];
  }

  // Shows the frame rates in the list of facts. `fps`: of the clip.
  note_rate(frame: FrameMessage, fps: number, is_live: boolean): void {
    const now = performance.now();
    ++this.seen.frames;
    if (now - this.seen.since <= 1000) return;
    this.seen = { frames: 0, since: now, rate: (1000 * this.seen.frames) / (now - this.seen.since) };
    const facts = element("facts").querySelectorAll("dd");
    if (facts.length < 5) return;
    facts[3].textContent = is_live
      ? `${short_number(frame.rate / fps)}× real time, ${Math.round(frame.rate)} fps`
      : "not running";
    facts[4].textContent = `${Math.round(this.seen.rate)} fps`;
  }

  show_words(choice: Choice): void {
    const sides = choice.comparison === "sides";
    const with_bake = choice.against === "bake";
    const left = element("tag-left");
    left.hidden = choice.comparison === "flesh";
    const other = with_bake ? this.beside_name : "skinning alone";
    left.textContent = sides ? other.replace(/^skinning/, "Skinning") : `${with_bake ? "Magenta" : "Blue"}: ${other}`;
    element("tag-right").hidden = !sides;
    element("tag-right").textContent = with_bake ? `Current: ${element("title").textContent}` : "Flesh";
    const has_scale = choice.colour === "lag" || choice.colour === "difference";
    element("lag-row").hidden = !has_scale;
    element("cut-row").hidden = checked("body") !== "tetrahedra";
    const millimetres = `${short_number(1e3 * choice.lag_scale)} mm`;
    element("lag-text").textContent = millimetres;
    element("cut-text").textContent = choice.cut ? `${short_number(choice.cut.place)} m` : "";
    if (this.body && this.body.solids.length > 0) {
      const fact = element("facts").querySelectorAll("dd")[5];
      const { touches } = this.picture.overlays;
      if (fact) fact.textContent = choice.solids ? `${grouped(touches)} vertices` : "–";
    }
    const key = `${choice.colour} ${millimetres} ${this.body?.body}`;
    if (key === this.legend_shown) return;
    this.legend_shown = key;
    show_legend(choice.colour, millimetres, this.body?.layers ?? [], this.user.paint_legend());
  }

  listen(): void {
    const look = element("look");
    look.addEventListener("change", (event) => {
      const { id } = event.target as HTMLElement;
      if (id === "floor") return this.picture.stage.show_floor(is_on("floor"));
      if (id === "against") {
        const name = element<HTMLSelectElement>("against").value;
        // So that choosing the bake again shows both again.
        if (name === "") this.last_beside = "";
        return this.user.send("beside", { name });
      }
      this.user.changed();
    });
    look.addEventListener("input", (event) => {
      if ((event.target as HTMLInputElement).type === "range") this.user.changed();
    });
  }
}
