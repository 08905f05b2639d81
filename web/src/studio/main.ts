// The page of `fascicle studio`: flesh that moves, looked at and touched.
import { Raycaster, Vector2, Vector3 } from "three";
import type { Texture } from "three";
import { load_texture_bytes } from "../common/body";
import { linear_of_hex, SCALE } from "../common/colours";
import { CurvePlot, value_text } from "../common/curves";
import type { Lane } from "../common/curves";
import { add_fact, checked, choose, choose_next, element, say, toggle } from "../common/dom";
import type { Curve } from "../common/film";
import { fill_help, listen_to_keys } from "../common/keys";
import type { BindingGroup } from "../common/keys";
import { grouped, short_number } from "../common/numbers";
import { VIEWS } from "../common/orbit";
import { follow_theme, style_value } from "../common/theme";
import { Connection, Refused } from "./connection";
import { blocks_for, Picture } from "./picture";
import type { Choice, ShownColour } from "./picture";
import type { BodyMessage, ClipMessage, Hello, KeyValue, PlayerMessage, Preset, SceneWarning, ServerMessage } from "./protocol";
import { hit } from "./surface";
import { TouchPanel } from "./touch";
import type { ArrayMessage, FrameMessage, Items } from "./wire";

const PLAY = "M4 2.5v11L13.5 8z";
const PAUSE = "M3.5 2.5h3.2v11H3.5zM9.3 2.5h3.2v11H9.3z";
const FORMATS = ["pc2", "mdd", "glb", "abc", "usda", "obj", "vtu"];
const TOAST = 4500; // ms
const SKIN: [number, number, number] = [...linear_of_hex("#e3ab8c")];

class Studio {
  private readonly picture = new Picture(element<HTMLCanvasElement>("picture"));
  private readonly connection: Connection;
  private readonly touch: TouchPanel;
  private hello: Hello | null = null;
  private body: BodyMessage | null = null;
  private readonly arrays = new Map<string, Items>();
  private clip: ClipMessage | null = null;
  private player: PlayerMessage | null = null;
  private frame: FrameMessage | null = null;
  private blocks = "";
  private plot: CurvePlot | null = null;
  private curves: Curve[] = [];
  private lanes: Lane[] = [];
  private toast_until = 0;
  private grip: { place: Vector3; finger: number } | null = null;
  private seen = { frames: 0, since: 0, rate: 0 };

  constructor(address: string) {
    this.connection = new Connection(address, {
      opened: () => this.set_status("Reading the body", "busy"),
      lost: () => this.lost(),
      said: (message) => this.said(message),
      array: (message) => this.array(message),
      frame: (message) => this.take_frame(message),
    });
    this.touch = new TouchPanel(element("groups"), element<HTMLInputElement>("find"), (path, value, gesture) =>
      this.set(path, value, gesture),
    );
  }

  start(): void {
    this.listen();
    follow_theme(() => {
      this.paint_stage();
      this.draw_curves();
    });
    this.connection.open();
    const tick = () => {
      if (this.is_new) this.refresh();
      this.picture.render(this.choice());
      if (this.toast_until > 0 && performance.now() > this.toast_until) {
        element("toast").hidden = true;
        this.toast_until = 0;
      }
      requestAnimationFrame(tick);
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
    this.drop_grip();
    for (const id of ["undo", "redo"]) element<HTMLButtonElement>(id).disabled = true;
    document.documentElement.dataset.state = "lost";
  }

  private set_status(text: string, state: string): void {
    const status = element("status");
    if (status.textContent !== text) status.textContent = text;
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
        return this.touch.fill(message.groups);
      case "presets":
        return this.list_presets(message.list);
      case "warnings":
        return this.list_warnings(message.list);
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
        return this.toast(
          message.seconds < 1
            ? `In the flesh after ${Math.round(1000 * message.seconds)} ms`
            : `In the flesh after ${short_number(message.seconds)} s`,
        );
      case "failed":
        return this.toast(`Taken back: ${message.error}`, true);
      case "recorded":
        document.documentElement.dataset.recorded = message.position_hash;
        return this.toast(
          `Recorded ${message.frames} frames in ${short_number(message.seconds)} s; hash of the last ${message.position_hash}`,
        );
      case "saved":
        element("save-note").textContent =
          `Wrote ${message.file}${message.kept_comments ? "" : "; its comments are lost"}. ${message.message}`;
        this.toast(`Saved ${message.file}`);
        document.documentElement.dataset.saved = message.file;
        return;
      case "baking":
        element("bake-phase").textContent =
          message.phase === "frames" ? `Frame ${message.frame} of ${message.frames}` : message.phase === "build" ? "Building the body" : "Before frame 0";
        element<HTMLProgressElement>("bake-bar").value = message.frames > 0 ? message.frame / message.frames : 0;
        return;
      case "baked":
        return this.baked(message);
      case "cancelled":
        this.end_bake();
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
    for (const input of document.querySelectorAll<HTMLInputElement>('input[name="tool"]')) input.disabled = !hello.can_touch;
    if (hello.restored && hello.message) this.toast(hello.message);
  }

  private array(message: ArrayMessage): void {
    this.arrays.set(message.name, message.items);
  }

  private async make_body(): Promise<void> {
    const body = this.body;
    if (!body) return;
    for (const name of [...this.arrays.keys()]) if (!body.arrays.includes(name)) this.arrays.delete(name);
    const textures: (Texture | null)[] = await Promise.all(
      body.textures.map((texture, k) => {
        const bytes = this.arrays.get(`texture.${k}`) as Uint8Array | undefined;
        return bytes ? load_texture_bytes(new Uint8Array(bytes), texture.type, texture.wrap[0], texture.wrap[1]) : null;
      }),
    );
    if (body !== this.body) return;
    const materials = body.materials.map((material) => ({
      name: material.name,
      colour: [material.colour[0], material.colour[1], material.colour[2]] as [number, number, number],
      cutoff: material.alpha_cutoff,
      texture: material.texture,
    }));
    this.picture.set_body(body, this.arrays, {
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
    const count = clip.frames + 1;
    const curve = (name: string, unit: string): Curve => ({ name, unit, limit: null, values: new Array(count).fill(null) });
    this.curves = [
      curve("lag", "mm"),
      curve("energy", "J"),
      curve("volume", "%"),
      { ...curve("real time", "×"), limit: 1 },
    ];
    this.lanes = this.curves.map((one, k) => ({ curve: one, colour: `--curve-${k}` }));
    this.list_curves();
    if (!this.plot) this.plot = new CurvePlot(element<HTMLCanvasElement>("plot"), count, (frame) => this.seek(frame));
    else this.plot.frames = count;
  }

  private list_curves(): void {
    const list = element("curve-list");
    list.replaceChildren();
    const lanes = this.lanes;
    for (const lane of lanes) {
      const label = document.createElement("label");
      const box = document.createElement("input");
      box.type = "checkbox";
      box.checked = true;
      const line = document.createElement("span");
      line.className = "line";
      line.style.background = `var(${lane.colour})`;
      const name = document.createElement("span");
      name.textContent = lane.curve.name;
      const value = document.createElement("output");
      label.append(box, line, name, value);
      const item = document.createElement("li");
      item.append(label);
      list.append(item);
      box.addEventListener("change", () => {
        this.lanes = this.lanes.filter((one) => one !== lane);
        if (box.checked) this.lanes.push(lane);
        this.draw_curves();
      });
    }
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
    if (this.clip && frame.frame < this.curves[0].values.length) {
      const values = [1e3 * frame.lag, frame.energy, 100 * frame.volume, frame.rate / this.clip.fps];
      values.forEach((value, k) => (this.curves[k].values[frame.frame] = Number.isFinite(value) ? value : null));
    }
    this.is_new = true;
  }

  private is_new = false; // whether a frame came that is not shown yet

  private refresh(): void {
    this.is_new = false;
    if (!this.frame) return;
    const choice = this.choice();
    this.picture.show(this.frame, choice);
    this.draw_curves();
    const clock = this.clip ? `${this.frame.frame} / ${this.clip.frames}   ${this.frame.time.toFixed(3)} s` : "";
    element("clock").textContent = clock;
    const scrub = element<HTMLInputElement>("scrub");
    if (document.activeElement !== scrub || this.player?.state === "playing") scrub.value = String(this.frame.frame);
    scrub.setAttribute("aria-valuetext", `frame ${clock}`);
    if (document.documentElement.dataset.state === "ready") {
      const is_recorded = this.frame.is_recorded;
      this.set_status(is_recorded ? "Recording" : this.player?.message || "Live", "live");
      document.documentElement.dataset.sequence = String(this.frame.sequence);
      document.documentElement.dataset.hash = this.frame.hash;
    }
    this.show_words(choice);
  }

  private draw_curves(): void {
    if (!this.plot) return;
    const frame = this.frame?.frame ?? 0;
    this.plot.draw(this.lanes, frame);
    const values = element("curve-list").querySelectorAll("output");
    this.curves.forEach((curve, k) => {
      if (values[k]) values[k].textContent = value_text(curve, frame);
    });
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
      .catch((error: Error) => this.toast(error.message, true))
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
    const colour = element<HTMLSelectElement>("colour").value as ShownColour;
    const is_on = (id: string) => element<HTMLInputElement>(id).checked;
    // Muscles and contact are of the model's own vertices.
    const tetrahedra = checked("body") === "tetrahedra" || colour === "muscles" || colour === "contact" || axis !== "";
    return {
      colour,
      comparison: checked("comparison") as Choice["comparison"],
      tetrahedra,
      cut: axis === "" ? null : { axis: Number(axis) as 0 | 1 | 2, place: this.cut_place(Number(axis)) },
      edges: is_on("edges"),
      fibres: is_on("fibres"),
      skeleton: is_on("skeleton"),
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
    this.show_legend(choice.colour, millimetres);
  }

  private legend_shown = "";
  private show_legend(colour: ShownColour, millimetres: string): void {
    const key = `${colour} ${millimetres} ${this.body?.body}`;
    if (key === this.legend_shown) return;
    this.legend_shown = key;
    const legend = element("legend");
    legend.replaceChildren();
    legend.hidden = colour === "materials" || colour === "muscles";
    const entry = (text: string, sign: HTMLElement | null) => {
      const item = document.createElement("span");
      if (sign) item.append(sign);
      item.append(text);
      legend.append(item);
    };
    if (colour === "layers") {
      for (const layer of this.body?.layers ?? []) {
        const swatch = document.createElement("i");
        swatch.className = "swatch";
        swatch.style.background = layer.colour;
        entry(layer.name, swatch);
      }
    } else if (colour === "lag" || colour === "contact") {
      const scale = document.createElement("i");
      scale.className = "scale";
      scale.style.background = `linear-gradient(to right, ${SCALE.join(", ")})`;
      entry("0", null);
      legend.append(scale);
      entry(colour === "lag" ? millimetres : "20 mm", null);
    }
  }

  // ---- Presets and warnings

  private list_presets(presets: Preset[]): void {
    const list = element("presets");
    list.replaceChildren();
    for (const preset of presets) {
      const button = document.createElement("button");
      button.type = "button";
      button.dataset.preset = preset.name;
      button.disabled = preset.why_not !== undefined || Object.keys(preset.changes).length === 0;
      const title = document.createElement("strong");
      title.textContent = preset.title;
      const doc = document.createElement("small");
      doc.textContent = preset.why_not ?? preset.doc;
      const changes = document.createElement("small");
      changes.textContent = Object.entries(preset.changes)
        .map(([path, value]) => `${path} = ${Array.isArray(value) ? value.join(", ") : value}`)
        .join("; ");
      button.append(title, doc, changes);
      button.addEventListener("click", () => this.send("preset", { name: preset.name }));
      const item = document.createElement("li");
      item.append(button);
      list.append(item);
    }
  }

  private list_warnings(warnings: SceneWarning[]): void {
    const list = element("warning-list");
    list.replaceChildren();
    element("warnings-tab").textContent = warnings.length > 0 ? `Warnings ${warnings.length}` : "Warnings";
    if (warnings.length === 0) {
      const item = document.createElement("li");
      item.textContent = "Nothing to warn of.";
      list.append(item);
    }
    for (const warning of warnings) {
      const item = document.createElement("li");
      const has_place = warning.places.length > 0;
      const line = document.createElement(has_place ? "button" : "p");
      line.textContent = warning.text;
      if (line instanceof HTMLButtonElement) {
        line.type = "button";
        let next = 0;
        line.addEventListener("click", () => {
          const place = warning.places[next % warning.places.length];
          const vertex = warning.vertices[next % Math.max(warning.vertices.length, 1)];
          ++next;
          this.picture.point_at(this.place_of(vertex) ?? place);
        });
      }
      item.append(line);
      list.append(item);
    }
  }

  // Where a vertex of the model is now, where frames tell.
  private place_of(vertex: number | undefined): [number, number, number] | null {
    const vertices = this.frame?.blocks.vertices;
    if (vertex === undefined || !vertices || 3 * vertex + 2 >= vertices.length) return null;
    return [vertices[3 * vertex], vertices[3 * vertex + 1], vertices[3 * vertex + 2]];
  }

  // ---- The hand

  private ray_at(x: number, y: number): Raycaster {
    const canvas = this.picture.stage.canvas;
    const box = canvas.getBoundingClientRect();
    const ray = new Raycaster();
    const { camera, orbit } = this.picture.stage;
    orbit.apply(camera);
    camera.updateMatrixWorld();
    ray.setFromCamera(new Vector2((2 * (x - box.left)) / box.width - 1, 1 - (2 * (y - box.top)) / box.height), camera);
    return ray;
  }

  // True where there is flesh to take.
  private grab(x: number, y: number, finger: number): boolean {
    const { surface, places } = this.picture;
    if (!surface || !places || checked("comparison") === "sides") return false;
    const { origin, direction } = this.ray_at(x, y).ray;
    const found = hit(origin.toArray(), direction.toArray(), places, surface);
    if (!found) return false;
    this.grip = { place: new Vector3(...found.place), finger };
    const is_model = this.choice().tetrahedra || !this.picture.has_skin;
    this.send("hand", {
      action: "grab",
      vertex: found.vertex,
      radius: 0,
      place: found.place,
      ...(is_model ? { of: "vertices" } : {}),
    });
    this.picture.show_grip(found.place);
    return true;
  }

  private drag(x: number, y: number): void {
    if (!this.grip) return;
    const ray = this.ray_at(x, y).ray;
    const normal = this.picture.stage.camera.getWorldDirection(new Vector3());
    const along = normal.dot(ray.direction);
    if (Math.abs(along) < 1e-6) return;
    const distance = normal.dot(this.grip.place.clone().sub(ray.origin)) / along;
    const place = ray.origin.clone().addScaledVector(ray.direction, distance);
    this.connection.command("hand", { action: "move", place: place.toArray() }).catch(() => this.drop_grip());
    this.picture.show_grip(place.toArray() as [number, number, number]);
  }

  private drop_grip(): void {
    this.grip = null;
    this.picture.show_grip(null);
  }

  private release(): void {
    if (!this.grip) return;
    this.drop_grip();
    this.send("hand", { action: "release" });
  }

  // Without a mouse: takes what is in the picture's middle, pulls it near and lets go.
  private tug(): void {
    const canvas = this.picture.stage.canvas;
    const box = canvas.getBoundingClientRect();
    const [x, y] = [box.left + box.width / 2, box.top + box.height / 2];
    if (!this.grab(x, y, -1)) {
      this.toast("No flesh in the middle of the picture", true);
      return;
    }
    const towards = this.picture.stage.camera.getWorldDirection(new Vector3()).multiplyScalar(-0.12 * this.picture.size);
    const place = this.grip!.place.clone().add(towards);
    this.send("hand", { action: "move", place: place.toArray() });
    setTimeout(() => this.release(), 450);
  }

  private listen_to_hand(): void {
    const canvas = this.picture.stage.canvas;
    // Before the camera's own listeners.
    canvas.addEventListener(
      "pointerdown",
      (event) => {
        if (checked("tool") !== "pull" || event.button !== 0 || event.shiftKey || !this.hello?.can_touch) return;
        if (!this.grab(event.clientX, event.clientY, event.pointerId)) return;
        canvas.setPointerCapture(event.pointerId);
        event.stopImmediatePropagation();
      },
      { capture: true },
    );
    canvas.addEventListener("pointermove", (event) => {
      if (this.grip?.finger === event.pointerId) this.drag(event.clientX, event.clientY);
    });
    for (const end of ["pointerup", "pointercancel"] as const)
      canvas.addEventListener(end, (event) => {
        if (this.grip?.finger === event.pointerId) this.release();
      });
  }

  // ---- Saving and baking

  private open_save(): void {
    element("save-error").textContent = "";
    element("save-note").textContent = this.hello ? `Into ${this.hello.folder}` : "";
    const name = element<HTMLInputElement>("save-name");
    if (!name.value && this.hello) name.value = `${this.hello.name.replaceAll(/[^A-Za-z0-9._-]/g, "_").replace(/\.toml$/, "")}.toml`;
    element<HTMLDialogElement>("save-dialog").showModal();
  }

  private async save(): Promise<void> {
    element("save-error").textContent = "";
    try {
      await this.connection.command("save", {
        file: element<HTMLInputElement>("save-name").value,
        overwrite: element<HTMLInputElement>("save-over").checked,
      });
    } catch (error) {
      element("save-error").textContent = (error as Error).message;
    }
  }

  private async bake(): Promise<void> {
    element("bake-error").textContent = "";
    element("bake-files").replaceChildren();
    element("bake-progress").hidden = false;
    element("bake-cancel").hidden = false;
    element<HTMLButtonElement>("bake-go").disabled = true;
    try {
      await this.connection.command("bake", {
        folder: element<HTMLInputElement>("bake-name").value,
        formats: [...document.querySelectorAll<HTMLInputElement>("#formats input:checked")].map((one) => one.value),
        overwrite: element<HTMLInputElement>("bake-over").checked,
      });
    } catch (error) {
      element("bake-error").textContent = (error as Error).message;
      this.end_bake();
    }
  }

  private end_bake(): void {
    element("bake-progress").hidden = true;
    element("bake-cancel").hidden = true;
    element<HTMLButtonElement>("bake-go").disabled = false;
  }

  private baked(message: Extract<ServerMessage, { type: "baked" }>): void {
    this.end_bake();
    const list = element("bake-files");
    list.replaceChildren();
    const add = (text: string) => {
      const item = document.createElement("li");
      item.textContent = text;
      list.append(item);
    };
    add(`${message.frames} frames in ${short_number(message.seconds)} s; hash of the last ${message.position_hash}`);
    for (const file of message.files) add(`${message.folder}/${file}`);
    for (const warning of message.warnings) add(warning);
    document.documentElement.dataset.baked = message.position_hash;
    this.toast(`Baked into ${message.folder}`);
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
    on("save", () => this.open_save());
    on("save-close", () => element<HTMLDialogElement>("save-dialog").close());
    element("save-form").addEventListener("submit", (event) => {
      event.preventDefault();
      void this.save();
    });
    const formats = element("formats");
    for (const name of FORMATS) {
      const label = document.createElement("label");
      label.className = "check";
      const box = document.createElement("input");
      box.type = "checkbox";
      box.value = name;
      box.checked = name === "pc2";
      label.append(box, name);
      formats.append(label);
    }
    on("bake", () => element<HTMLDialogElement>("bake-dialog").showModal());
    on("bake-close", () => element<HTMLDialogElement>("bake-dialog").close());
    on("bake-cancel", () => this.send("cancel"));
    element("bake-form").addEventListener("submit", (event) => {
      event.preventDefault();
      void this.bake();
    });
    const help = element<HTMLDialogElement>("help");
    on("help-open", () => help.showModal());
    on("help-close", () => help.close());
    const groups = this.bindings(help);
    fill_help(element("help-table"), groups);
    listen_to_keys(groups, () => document.querySelector("dialog[open]") !== null);
    this.listen_to_hand();
    window.addEventListener("resize", () => this.draw_curves());
  }

  private bindings(help: HTMLDialogElement): BindingGroup[] {
    const { orbit } = this.picture.stage;
    const click = (id: string) => () => element(id).click();
    const next_option = (id: string, by: number) => {
      const list = element<HTMLSelectElement>(id);
      for (let k = 1; k <= list.options.length; ++k) {
        const at = (list.selectedIndex + by * k + k * list.options.length) % list.options.length;
        if (list.options[at].disabled) continue;
        list.selectedIndex = at;
        break;
      }
      list.dispatchEvent(new Event("change", { bubbles: true }));
      say(list.selectedOptions[0]?.text ?? "");
    };
    const move_range = (id: string, by: number) => {
      const range = element<HTMLInputElement>(id);
      range.value = String(Number(range.value) + by);
      range.dispatchEvent(new Event("input", { bubbles: true }));
    };
    return [
      {
        title: "Time",
        bindings: [
          { keys: [" "], shown: "Space", does: "Play or pause", run: click("play") },
          { keys: ["ArrowRight"], shown: "→", does: "A frame forward", run: click("forward") },
          { keys: ["ArrowLeft"], shown: "←", does: "Ten frames back", run: () => this.seek((this.frame?.frame ?? 0) - 10) },
          { keys: ["Home"], shown: "Home", does: "From the start", run: click("restart") },
          { keys: ["l"], shown: "L", does: "Loop", run: click("loop") },
          { keys: ["["], shown: "[", does: "Slower", run: () => this.change_speed(-1) },
          { keys: ["]"], shown: "]", does: "Faster", run: () => this.change_speed(1) },
          { keys: ["q"], shown: "Q", does: "Record, or stop it", run: click("record") },
        ],
      },
      {
        title: "Change",
        bindings: [
          { keys: ["1"], shown: "1", does: "Keys to touch", run: () => choose("tab", "touch") },
          { keys: ["2"], shown: "2", does: "Wishes", run: () => choose("tab", "wishes") },
          { keys: ["3"], shown: "3", does: "Warnings", run: () => choose("tab", "warnings") },
          { keys: ["/"], shown: "/", does: "Find a key", run: () => { choose("tab", "touch"); element("find").focus(); } },
          { keys: ["z"], shown: "Z", does: "Undo", run: click("undo") },
          { keys: ["y"], shown: "Y", does: "Redo", run: click("redo") },
          { keys: ["x"], shown: "X", does: "Save", run: click("save") },
          { keys: ["k"], shown: "K", does: "Bake", run: click("bake") },
          { keys: ["h"], shown: "H", does: "Mouse: turn or pull", run: () => choose_next("tool") },
          { keys: ["p"], shown: "P", does: "Tug at the picture's middle", run: () => this.tug() },
        ],
      },
      {
        title: "Look",
        bindings: [
          { keys: ["m"], shown: "M", does: "Next colours", run: () => next_option("colour", 1) },
          { keys: ["c"], shown: "C", does: "Flesh, ghost, both", run: () => choose_next("comparison") },
          { keys: ["b"], shown: "B", does: "Skin or tetrahedra", run: () => choose_next("body") },
          { keys: ["u"], shown: "U", does: "Cut: next axis", run: () => { choose("body", "tetrahedra"); next_option("cut-axis", 1); } },
          { keys: [","], shown: ",", does: "Move the cut back", run: () => move_range("cut", -2) },
          { keys: ["."], shown: ".", does: "Move the cut forward", run: () => move_range("cut", 2) },
          { keys: ["i"], shown: "I", does: "Fibres", run: () => toggle("fibres") },
          { keys: ["j"], shown: "J", does: "Skeleton", run: () => toggle("skeleton") },
          { keys: ["o"], shown: "O", does: "Inside out", run: () => toggle("inverted") },
          { keys: ["e"], shown: "E", does: "Edges", run: () => toggle("edges") },
          { keys: ["n"], shown: "N", does: "Floor", run: () => toggle("floor") },
        ],
      },
      {
        title: "Camera",
        bindings: [
          { keys: ["a"], shown: "A", does: "Turn left", run: () => orbit.turn(0.12, 0) },
          { keys: ["d"], shown: "D", does: "Turn right", run: () => orbit.turn(-0.12, 0) },
          { keys: ["w"], shown: "W", does: "Up", run: () => orbit.turn(0, 0.1) },
          { keys: ["s"], shown: "S", does: "Down", run: () => orbit.turn(0, -0.1) },
          { keys: ["Shift+a"], shown: "Shift A", does: "Move left", run: () => orbit.pan(0.05, 0) },
          { keys: ["Shift+d"], shown: "Shift D", does: "Move right", run: () => orbit.pan(-0.05, 0) },
          { keys: ["Shift+w"], shown: "Shift W", does: "Move up", run: () => orbit.pan(0, 0.05) },
          { keys: ["Shift+s"], shown: "Shift S", does: "Move down", run: () => orbit.pan(0, -0.05) },
          { keys: ["+", "="], shown: "+", does: "Nearer", run: () => orbit.zoom(1.15) },
          { keys: ["-"], shown: "−", does: "Farther", run: () => orbit.zoom(1 / 1.15) },
          { keys: ["r"], shown: "R", does: "Home", run: () => orbit.reset() },
        ],
      },
      {
        title: "Page",
        bindings: [
          { keys: ["t"], shown: "T", does: "Dark or light", run: click("theme") },
          { keys: ["?"], shown: "?", does: "These keys", run: () => help.showModal() },
        ],
      },
    ];
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
