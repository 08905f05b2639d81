// The page of `fascicle studio`: flesh that moves, looked at and touched.
import type { Texture } from "three";
import { load_texture_bytes } from "../common/body";
import { linear_of_hex } from "../common/colours";
import { add_fact, checked, choose, element, say } from "../common/dom";
import { fill_help, listen_to_keys } from "../common/keys";
import { grouped, short_number } from "../common/numbers";
import { VIEWS } from "../common/orbit";
import { follow_theme, style_value } from "../common/theme";
import { bindings } from "./bindings";
import { Bones } from "./bones";
import { Connection, Refused } from "./connection";
import { LiveCurves } from "./curves";
import { Dialogs } from "./dialogs";
import { Hand } from "./hand";
import { list_presets, list_warnings, show_legend } from "./lists";
import { blocks_for, Picture } from "./picture";
import type { Choice, ShownColour } from "./picture";
import { Painter } from "./paint";
import type { BodyMessage, ClipMessage, Hello, KeyValue, PlayerMessage, SceneWarning, ServerMessage } from "./protocol";
import { TouchPanel } from "./touch";
import type { ArrayMessage, FrameMessage, Items } from "./wire";

const PLAY = "M4 2.5v11L13.5 8z";
const PAUSE = "M3.5 2.5h3.2v11H3.5zM9.3 2.5h3.2v11H9.3z";
const TOAST = 4500; // ms
const SKIN: [number, number, number] = [...linear_of_hex("#e3ab8c")];

class Studio {
  private readonly picture = new Picture(element<HTMLCanvasElement>("picture"));
  private readonly connection: Connection;
  private readonly touch: TouchPanel;
  private hello: Hello | null = null;
  private body: BodyMessage | null = null;
  private readonly arrays = new Map<string, Items>();
  private readonly textures = new Map<Items, Promise<Texture | null>>(); // by the bytes that they are of
  private clip: ClipMessage | null = null;
  private player: PlayerMessage | null = null;
  private frame: FrameMessage | null = null;
  private blocks = "";
  private readonly curves = new LiveCurves((frame) => this.seek(frame));
  private toast_until = 0;
  private readonly hand: Hand;
  private readonly painter: Painter;
  private readonly bones: Bones;
  private readonly dialogs: Dialogs;
  private legend_shown = "";
  private warnings: SceneWarning[] = [];
  private bake_warnings: SceneWarning[] = [];
  private seen = { frames: 0, since: 0, rate: 0 };

  constructor(address: string) {
    this.connection = new Connection(address, {
      opened: () => this.set_status("Reading the body", "busy"),
      lost: () => this.lost(),
      said: (message) => this.said(message),
      array: (message) => this.array(message),
      frame: (message) => this.take_frame(message),
    });
    const command = (type: string, members: object) => this.connection.command(type, members);
    this.hand = new Hand(this.picture, {
      can_touch: () => this.hello?.can_touch ?? false,
      draws_model: () => this.choice().tetrahedra || !this.picture.has_skin,
      send: (type, members) => this.send(type, members),
      command,
      say: (text, is_bad) => this.toast(text, is_bad),
    });
    this.painter = new Painter(this.picture, {
      command,
      say: (text, is_bad) => this.toast(text, is_bad),
      changed: () => {
        this.legend_shown = "";
        this.is_new = true;
      },
    });
    this.picture.paint_colour = this.painter.colour;
    this.bones = new Bones(this.picture, {
      command,
      say: (text, is_bad) => this.toast(text, is_bad),
      joints: () => this.frame?.blocks.joints ?? null,
    });
    this.dialogs = new Dialogs({
      hello: () => this.hello,
      command,
      send: (type) => this.send(type),
      say: (text) => this.toast(text),
    });
    this.touch = new TouchPanel(
      element("groups"),
      element<HTMLInputElement>("find"),
      (path, value, gesture) => this.set(path, value, gesture),
      element("nothing-found"),
    );
  }

  start(): void {
    this.listen();
    follow_theme(() => {
      this.paint_stage();
      this.curves.draw(this.frame?.frame ?? 0);
    });
    this.connection.open();
    const tick = () => {
      // First, so that what goes wrong in one picture is not the end of all.
      requestAnimationFrame(tick);
      if (this.is_new) this.refresh();
      this.picture.render(this.choice());
      if (this.toast_until > 0 && performance.now() > this.toast_until) {
        element("toast").hidden = true;
        this.toast_until = 0;
      }
    };
    requestAnimationFrame(tick);
  }

  private paint_stage(): void {
    this.picture.stage.paint(style_value("--stage"), style_value("--grid"), Number(style_value("--grid-opacity")));
  }

  // ---- What the server says

  private lost(): void {
    this.set_status("The program is gone. Start it again and open its address: nothing is lost", "lost");
    this.blocks = "";
    this.dialogs.end_bake();
    this.hand.drop();
    for (const id of ["undo", "redo"]) element<HTMLButtonElement>(id).disabled = true;
    document.documentElement.dataset.state = "lost";
  }

  private set_status(text: string, state: string): void {
    const status = element("status");
    if (status.textContent !== text) status.textContent = text;
    status.title = text; // it may be cut off
    status.dataset.state = state;
  }

  private toast(text: string, is_bad = false): void {
    if (!text) return;
    const toast = element("toast");
    toast.textContent = text;
    toast.dataset.bad = String(is_bad);
    toast.hidden = false;
    this.toast_until = performance.now() + (is_bad ? 2 : 1) * TOAST;
  }

  private said(message: ServerMessage): void {
    switch (message.type) {
      case "hello":
        return this.greet(message);
      case "body":
        this.body = message;
        this.picture.most_lag = 0;
        return;
      case "clip":
        return this.set_clip(message);
      case "keys":
        this.bones.set_keys(message.groups);
        return this.touch.fill(message.groups);
      case "paint":
        return this.painter.said(message);
      case "presets":
        return list_presets(message.list, (name) => this.send("preset", { name }));
      case "warnings":
        this.warnings = message.list;
        return this.list_warnings();
      case "history": {
        const undo = element<HTMLButtonElement>("undo");
        const redo = element<HTMLButtonElement>("redo");
        undo.disabled = message.undo === null;
        redo.disabled = message.redo === null;
        undo.title = message.undo === null ? "" : `Undo ${message.undo}`;
        redo.title = message.redo === null ? "" : `Redo ${message.redo}`;
        element("save").textContent = message.saved ? "Saved" : "Save";
        return;
      }
      case "player":
        this.player = message;
        return this.show_player();
      case "ready":
        void this.make_body();
        return;
      case "changed":
        return this.toast(message.message);
      case "applied":
        document.documentElement.dataset.applied = String(message.revision);
        // What was computed before is of other flesh.
        this.curves.clear();
        if (this.player?.state === "paused") return this.toast("In force; play to see it");
        return this.toast(
          message.seconds < 1
            ? `In the flesh after ${Math.round(1000 * message.seconds)} ms`
            : `In the flesh after ${short_number(message.seconds)} s`,
        );
      case "failed":
        if (message.what === "bake") this.dialogs.end_bake();
        if (message.what === "change") this.touch.restore();
        return this.toast(message.what === "change" ? `Taken back: ${message.error}` : message.error, true);
      case "recorded":
        document.documentElement.dataset.recorded = message.position_hash;
        return this.toast(
          `Recorded ${message.frames} frames in ${short_number(message.seconds)} s; hash of the last ${message.position_hash}`,
        );
      case "saved":
        return this.dialogs.saved(message);
      case "baking":
        return this.dialogs.baking(message);
      case "baked":
        // What a bake found stands until the next one, or until the body is another one.
        this.bake_warnings = message.warnings.map((text) => ({ text: `The bake: ${text}`, places: [], vertices: [] }));
        this.list_warnings();
        return this.dialogs.baked(message);
      case "cancelled":
        this.dialogs.end_bake();
        return this.toast("Stopped");
      case "refused":
        return this.toast(message.error, true);
      default:
        return;
    }
  }

  private greet(hello: Hello): void {
    this.hello = hello;
    if (hello.protocol !== 1) {
      this.connection.close();
      this.fail(`The program speaks protocol ${hello.protocol}, and this page 1: load the page again.`);
      return;
    }
    element("title").textContent = hello.name;
    document.title = `${hello.name} – fascicle studio`;
    element("subtitle").textContent = hello.device;
    const note = element("why-not");
    note.hidden = hello.can_touch;
    note.textContent = hello.why_not ?? "";
    element("find").parentElement!.hidden = !hello.can_touch;
    for (const id of ["save", "bake", "record"]) element<HTMLButtonElement>(id).disabled = !hello.can_touch;
    for (const input of document.querySelectorAll<HTMLInputElement>('input[name="tool"]'))
      input.disabled = !hello.can_touch || ["paint", "bones"].includes(input.value);
    if (hello.restored && hello.message) this.toast(hello.message);
  }

  private array(message: ArrayMessage): void {
    // What is painted is of no body.
    if (message.name.startsWith("paint.")) this.painter.array(message.name, message.items);
    else this.arrays.set(message.name, message.items);
  }

  private async make_body(): Promise<void> {
    const body = this.body;
    if (!body) return;
    for (const name of [...this.arrays.keys()]) if (!body.arrays.includes(name)) this.arrays.delete(name);
    const textures: (Texture | null)[] = await Promise.all(
      body.textures.map((texture, k) => {
        const bytes = this.arrays.get(`texture.${k}`) as Uint8Array | undefined;
        if (!bytes) return null;
        // What is the same as before is not decoded again.
        let texture_of = this.textures.get(bytes);
        if (!texture_of) {
          texture_of = load_texture_bytes(new Uint8Array(bytes), texture.type, texture.wrap[0], texture.wrap[1]);
          this.textures.set(bytes, texture_of);
        }
        return texture_of;
      }),
    );
    if (body !== this.body) return;
    for (const [bytes, texture] of this.textures) {
      if ([...this.arrays.values()].includes(bytes)) continue;
      this.textures.delete(bytes);
      void texture.then((one) => one?.dispose());
    }
    const materials = body.materials.map((material) => ({
      name: material.name,
      colour: [material.colour[0], material.colour[1], material.colour[2]] as [number, number, number],
      cutoff: material.alpha_cutoff,
      texture: material.texture,
    }));
    this.picture.set_body(body, new Map(this.arrays), {
      // What says nothing of its colour is skin.
      materials: materials.length > 0 ? materials : [{ name: "skin", colour: SKIN, cutoff: 0, texture: -1 }],
      textures,
      layers: body.layers,
    });
    const facts = element("facts");
    facts.replaceChildren();
    add_fact(facts, "Vertices", grouped(body.counts.vertices));
    add_fact(facts, "Tetrahedra", grouped(body.counts.tetrahedra));
    add_fact(facts, "Skin", grouped(body.counts.surface_vertices));
    add_fact(facts, "Solver", "–");
    add_fact(facts, "Page", "–");
    const offer = (value: string, is_there: boolean) => {
      const option = document.querySelector<HTMLOptionElement>(`#colour option[value="${value}"]`);
      if (option) option.disabled = !is_there;
    };
    offer("muscles", this.picture.has_muscles);
    this.bones.set_body(body, this.hello?.can_touch ?? false);
    const skin = document.querySelector<HTMLInputElement>('input[name="body"][value="skin"]');
    if (skin) skin.disabled = !this.picture.has_skin;
    if (!this.picture.has_skin) choose("body", "tetrahedra");
    this.paint_stage();
    this.ask_for_blocks();
    this.refresh();
    document.documentElement.dataset.state = "ready";
  }

  private set_clip(clip: ClipMessage): void {
    const is_new = !this.clip || this.clip.frames !== clip.frames;
    this.clip = clip;
    element<HTMLInputElement>("scrub").max = String(clip.frames);
    if (!is_new) return;
    this.curves.begin(clip.frames + 1);
  }

  private take_frame(frame: FrameMessage): void {
    if (frame.body !== this.body?.body && this.body) {
      // A frame of the body before, on its way when the new one came.
      if (frame.body < this.body.body) return;
    }
    this.frame = frame;
    const now = performance.now();
    ++this.seen.frames;
    if (now - this.seen.since > 1000) {
      this.seen = { frames: 0, since: now, rate: (1000 * this.seen.frames) / (now - this.seen.since) };
      const facts = element("facts").querySelectorAll("dd");
      if (facts.length >= 5) {
        facts[3].textContent = `${Math.round(frame.rate)} frames/s`;
        facts[4].textContent = `${Math.round(this.seen.rate)} frames/s`;
      }
    }
    // After a jump along the clip the flesh has been carried there, and says nothing of how it moves.
    if (this.clip && !frame.begins) this.curves.note(frame, this.clip.fps);
    this.is_new = true;
  }

  private is_new = false; // whether a frame came that is not shown yet

  private refresh(): void {
    this.is_new = false;
    if (!this.frame) return;
    const choice = this.choice();
    this.picture.show(this.frame, choice);
    this.bones.mark();
    this.curves.draw(this.frame?.frame ?? 0);
    const clock = this.clip ? `${this.frame.frame} / ${this.clip.frames}   ${this.frame.time.toFixed(3)} s` : "";
    element("clock").textContent = clock;
    const scrub = element<HTMLInputElement>("scrub");
    if (document.activeElement !== scrub || this.player?.state === "playing") scrub.value = String(this.frame.frame);
    scrub.setAttribute("aria-valuetext", `frame ${clock}`);
    if (document.documentElement.dataset.state === "ready") {
      this.set_status(this.status_text(), "live");
      document.documentElement.dataset.sequence = String(this.frame.sequence);
      document.documentElement.dataset.hash = this.frame.hash;
    }
    this.show_words(choice);
  }

  private status_text(): string {
    if (this.player?.message) return this.player.message;
    switch (this.player?.state) {
      case "recording":
        return "Recording";
      case "baking":
        return "Baking";
      case "paused":
        return this.frame?.begins && this.hello?.can_touch ? "Paused; play to see the flesh move" : "Paused";
      default:
        return this.hello?.can_touch === false ? "A bake" : "Live";
    }
  }

  private show_player(): void {
    const player = this.player!;
    const plays = player.state === "playing" || player.state === "recording";
    element("play").setAttribute("aria-label", plays ? "Pause" : "Play");
    element("play-sign").setAttribute("d", plays ? PAUSE : PLAY);
    element<HTMLInputElement>("loop").checked = player.loop;
    const speed = element<HTMLSelectElement>("speed");
    if (document.activeElement !== speed) {
      const near = [...speed.options].reduce((best, one) =>
        Math.abs(Number(one.value) - player.speed) < Math.abs(Number(best.value) - player.speed) ? one : best,
      );
      speed.value = near.value;
    }
    element("record").textContent = player.state === "recording" ? "Stop" : "Record";
    if (document.documentElement.dataset.state === "ready") this.set_status(this.status_text(), "live");
  }

  // ---- What the user does

  private send(type: string, members: object = {}): void {
    this.connection.command(type, members).then(
      (text) => this.toast(text),
      (error: Error) => this.toast(error.message, true),
    );
  }

  private pending: { path: string; value: KeyValue; gesture: number | null } | null = null;
  private is_sending = false;

  // One change is on its way at a time; of those that wait the last one goes.
  private set(path: string, value: KeyValue, gesture: number | null): void {
    if (this.pending && this.pending.path !== path) this.flush();
    this.pending = { path, value, gesture };
    if (!this.is_sending) this.flush();
  }

  private flush(): void {
    const pending = this.pending;
    if (!pending) return;
    this.pending = null;
    this.is_sending = true;
    this.connection
      .command("set", {
        changes: { [pending.path]: pending.value },
        ...(pending.gesture === null ? {} : { gesture: pending.gesture }),
      })
      .catch((error: Error) => {
        this.touch.restore();
        this.toast(error.message, true);
      })
      .finally(() => {
        this.is_sending = false;
        this.flush();
      });
  }

  private seek(frame: number): void {
    this.send("seek", { frame: Math.min(Math.max(Math.round(frame), 0), this.clip?.frames ?? 0) });
  }

  private choice(): Choice {
    const axis = element<HTMLSelectElement>("cut-axis").value;
    const paints = this.painter.is_chosen;
    const colour = paints ? "paint" : (element<HTMLSelectElement>("colour").value as ShownColour);
    const is_on = (id: string) => element<HTMLInputElement>(id).checked;
    // Muscles and contact are of the model's own vertices.
    const of_model = checked("body") === "tetrahedra" || colour === "muscles" || colour === "contact" || axis !== "";
    const tetrahedra = of_model && !paints;
    return {
      colour,
      comparison: checked("comparison") as Choice["comparison"],
      tetrahedra,
      cut: axis === "" ? null : { axis: Number(axis) as 0 | 1 | 2, place: this.cut_place(Number(axis)) },
      edges: is_on("edges"),
      fibres: is_on("fibres"),
      skeleton: is_on("skeleton") || this.bones.is_chosen,
      inverted: is_on("inverted"),
      lag_scale: (this.picture.scale_for_lag() * Number(element<HTMLInputElement>("lag-scale").value)) / 100,
    };
  }

  private cut_place(axis: number): number {
    if (!this.body) return 0;
    const [least, most] = this.body.bounds;
    const share = Number(element<HTMLInputElement>("cut").value) / 100;
    return least[axis] + share * (most[axis] - least[axis]);
  }

  private ask_for_blocks(): void {
    const blocks = blocks_for(this.choice(), this.picture.has_skin);
    const key = blocks.join();
    if (key === this.blocks) return;
    this.blocks = key;
    this.connection.command("show", { blocks }).catch(() => (this.blocks = ""));
  }

  private looked(): void {
    this.ask_for_blocks();
    this.refresh();
    this.picture.stage.invalidate();
  }

  private show_words(choice: Choice): void {
    const sides = choice.comparison === "sides";
    element("tag-left").hidden = choice.comparison === "flesh";
    element("tag-left").textContent = sides ? "Skinning alone" : "Blue: skinning alone";
    element("tag-right").hidden = !sides;
    element("tag-right").textContent = "Flesh";
    element("lag-row").hidden = choice.colour !== "lag";
    element("cut-row").hidden = checked("body") !== "tetrahedra";
    const millimetres = `${short_number(1e3 * choice.lag_scale)} mm`;
    element("lag-text").textContent = millimetres;
    element("cut-text").textContent = choice.cut ? `${short_number(choice.cut.place)} m` : "";
    const key = `${choice.colour} ${millimetres} ${this.body?.body}`;
    if (key === this.legend_shown) return;
    this.legend_shown = key;
    show_legend(choice.colour, millimetres, this.body?.layers ?? [], this.painter.legend());
  }

  private list_warnings(): void {
    list_warnings([...this.bake_warnings, ...this.warnings], (place, vertex) =>
      this.picture.point_at(this.place_of(vertex) ?? place),
    );
  }

  // Where a vertex of the model is now, where frames tell.
  private place_of(vertex: number | undefined): [number, number, number] | null {
    const vertices = this.frame?.blocks.vertices;
    if (vertex === undefined || !vertices || 3 * vertex + 2 >= vertices.length) return null;
    return [vertices[3 * vertex], vertices[3 * vertex + 1], vertices[3 * vertex + 2]];
  }

  // ---- Controls and keys

  private listen(): void {
    const on = (id: string, run: () => void) => element(id).addEventListener("click", run);
    const plays = () => this.player?.state === "playing";
    on("play", () => this.send(plays() ? "pause" : "play"));
    on("forward", () => this.send("step"));
    on("restart", () => this.send("restart"));
    on("record", () => this.send(this.player?.state === "recording" ? "cancel" : "record"));
    on("undo", () => this.send("undo"));
    on("redo", () => this.send("redo"));
    const scrub = element<HTMLInputElement>("scrub");
    scrub.addEventListener("input", () => this.seek(Number(scrub.value)));
    const loop = element<HTMLInputElement>("loop");
    loop.addEventListener("change", () => this.send("loop", { on: loop.checked }));
    const speed = element<HTMLSelectElement>("speed");
    speed.addEventListener("change", () => this.send("speed", { factor: Number(speed.value) }));
    element("look").addEventListener("change", (event) => {
      if ((event.target as HTMLElement).id === "floor") {
        this.picture.stage.show_floor(element<HTMLInputElement>("floor").checked);
        return;
      }
      this.looked();
    });
    element("look").addEventListener("input", (event) => {
      if ((event.target as HTMLInputElement).type === "range") this.looked();
    });
    element("tab").addEventListener("change", () => {
      for (const id of ["touch", "wishes", "warnings"]) element(id).hidden = checked("tab") !== id;
      if (checked("tab") !== "warnings") this.picture.point_at_nothing();
    });
    element("views").addEventListener("click", (event) => {
      const view = (event.target as HTMLElement).dataset.view;
      if (view) this.picture.stage.orbit.look(VIEWS[view]);
    });
    this.dialogs.listen();
    const help = element<HTMLDialogElement>("help");
    on("help-open", () => help.showModal());
    on("help-close", () => help.close());
    const groups = bindings(this.picture.stage.orbit, {
      step_back: () => this.seek((this.frame?.frame ?? 0) - 1),
      change_speed: (by) => this.change_speed(by),
      tug: () => this.hand.tug(),
      dab: () => this.painter.dab(),
      resize_brush: (by) => this.painter.resize(by),
      help: () => help.showModal(),
    });
    fill_help(element("help-table"), groups);
    listen_to_keys(groups, () => document.querySelector("dialog[open]") !== null);
    // As elsewhere; a field that is typed in has its own.
    window.addEventListener("keydown", (event) => {
      if (!(event.ctrlKey || event.metaKey) || event.target instanceof HTMLInputElement) return;
      const key = event.key.toLowerCase();
      if (key !== "z" && key !== "y") return;
      event.preventDefault();
      element(key === "y" || event.shiftKey ? "redo" : "undo").click();
    });
    this.hand.listen();
    this.painter.listen();
    this.bones.listen();
    window.addEventListener("resize", () => this.curves.draw(this.frame?.frame ?? 0));
  }

  private change_speed(by: number): void {
    const speed = element<HTMLSelectElement>("speed");
    speed.selectedIndex = Math.min(Math.max(speed.selectedIndex + by, 0), speed.options.length - 1);
    speed.dispatchEvent(new Event("change"));
    say(`speed ${speed.value}`);
  }

  fail(text: string): void {
    const failure = element("failure");
    failure.hidden = false;
    failure.textContent = text;
    document.documentElement.dataset.state = "failed";
  }
}

const token = location.hash.slice(1);
try {
  const studio = new Studio(`ws://${location.host}/live?token=${encodeURIComponent(token)}`);
  if (token === "") studio.fail("The address has no token: open the one that fascicle studio printed.");
  else studio.start();
} catch (error) {
  const failure = element("failure");
  failure.hidden = false;
  failure.textContent = `The studio cannot be shown: ${error instanceof Refused || error instanceof Error ? error.message : String(error)}`;
  document.documentElement.dataset.state = "failed";
}
