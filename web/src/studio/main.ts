// The page of `fascicle studio`: shows the live simulation and lets the user edit it.
import { element } from "../common/dom";
import { fill_help, listen_to_keys } from "../common/keys";
import { short_number } from "../common/numbers";
import { VIEWS } from "../common/orbit";
import { follow_theme, style_value } from "../common/theme";
import { bindings } from "./bindings";
import { Bones } from "./bones";
import { Changes } from "./changes";
import { Connection, Refused } from "./connection";
import { LiveCurves } from "./curves";
import { Dialogs } from "./dialogs";
import { Hand } from "./hand";
import { list_presets, list_warnings } from "./lists";
import { Look } from "./look";
import { LookLoader } from "./looks";
import { fail, Notices, show_device, show_hello, show_history } from "./notices";
import { Painter } from "./paint";
import { Picture } from "./picture";
import type { BesideMessage, BodyMessage, ClipMessage, Hello, SceneWarning, ServerMessage } from "./protocol";
import { TouchPanel } from "./touch";
import { Transport } from "./transport";
import type { ArrayMessage, FrameMessage, Items } from "./wire";

const BESIDE = "beside."; // prefix of the comparison bake's arrays

class Studio {
  private readonly picture = new Picture(element<HTMLCanvasElement>("picture"));
  private readonly connection: Connection;
  private readonly notices = new Notices();
  private readonly transport = new Transport((type, members) => this.send(type, members));
  private readonly changes: Changes;
  private readonly touch: TouchPanel;
  private readonly look: Look;
  private readonly loader = new LookLoader();
  private readonly curves = new LiveCurves((frame) => this.transport.seek(frame));
  private readonly hand: Hand;
  private readonly painter: Painter;
  private readonly bones: Bones;
  private readonly dialogs: Dialogs;
  private hello: Hello | null = null;
  private body: BodyMessage | null = null;
  private readonly arrays = new Map<string, Items>();
  private beside: BesideMessage | null = null;
  private readonly arrays_beside = new Map<string, Items>(); // without the prefix
  private frame: FrameMessage | null = null;
  private warnings: SceneWarning[] = [];
  private bake_warnings: SceneWarning[] = [];

  constructor(address: string) {
    this.connection = new Connection(address, {
      opened: () => this.notices.set_status("Loading the body", "busy"),
      lost: () => this.lost(),
      said: (message) => this.said(message),
      array: (message) => this.array(message),
      frame: (message) => this.take_frame(message),
    });
    const command = (type: string, members: object) => this.connection.command(type, members);
    const say = (text: string, is_bad?: boolean) => this.notices.toast(text, is_bad);
    this.changes = new Changes({
      command,
      refused: (error) => {
        this.touch.restore();
        say(error.message, true);
      },
    });
    this.hand = new Hand(this.picture, {
      can_touch: () => this.hello?.can_touch ?? false,
      draws_model: () => this.look.choice().tetrahedra || !this.picture.has_skin,
      send: (type, members) => this.send(type, members),
      command,
      say,
    });
    this.painter = new Painter(this.picture, {
      command,
      say,
      changed: () => {
        this.look.mend_legend();
        this.is_new = true;
      },
    });
    this.picture.paint_colour = this.painter.colour;
    this.bones = new Bones(this.picture, {
      command,
      say,
      joints: () => this.frame?.blocks.joints ?? null,
    });
    this.look = new Look(this.picture, {
      command,
      send: (type, members) => this.send(type, members),
      changed: () => this.looked(),
      paints: () => this.painter.is_chosen,
      chooses_bones: () => this.bones.is_chosen,
      paint_legend: () => this.painter.legend(),
    });
    this.dialogs = new Dialogs({
      hello: () => this.hello,
      command,
      send: (type) => this.send(type),
      say,
    });
    this.touch = new TouchPanel(
      element("groups"),
      element<HTMLInputElement>("find"),
      (path, value, gesture) => this.changes.set(path, value, gesture),
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
      // First, so that an error in one picture does not stop the loop.
      requestAnimationFrame(tick);
      if (this.is_new) this.refresh();
      this.picture.stage.moves = this.transport.moves;
      this.picture.render(this.look.choice());
      this.notices.tick();
    };
    requestAnimationFrame(tick);
  }

  private paint_stage(): void {
    this.picture.stage.paint(style_value("--stage"), style_value("--grid"), Number(style_value("--grid-opacity")));
  }

  // ---- Messages from the server

  private lost(): void {
    this.notices.set_status(
      "Connection lost. Restart fascicle studio and open the address that it prints; no changes are lost",
      "lost",
    );
    this.look.forget();
    this.dialogs.end_bake();
    this.hand.drop();
    for (const id of ["undo", "redo"]) element<HTMLButtonElement>(id).disabled = true;
    document.documentElement.dataset.state = "lost";
  }

  private said(message: ServerMessage): void {
    switch (message.type) {
      case "hello":
        return this.greet(message);
      case "device":
        return show_device(message.device);
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
      case "beside":
        return this.set_beside(message);
      case "presets":
        return list_presets(message.list, (name) => this.send("preset", { name }));
      case "warnings":
        this.warnings = message.list;
        return this.list_warnings();
      case "history":
        return show_history(message);
      case "player":
        this.transport.set_player(message);
        return this.show_status();
      case "ready":
        void this.make_body();
        return;
      case "changed":
        return this.notices.toast(message.message);
      case "applied":
        document.documentElement.dataset.applied = String(message.revision);
        // Earlier values are those before the change.
        this.curves.clear();
        if (this.transport.player?.state === "paused") return this.notices.toast("Applied; play to see the effect");
        return this.notices.toast(
          message.seconds < 1
            ? `Applied in ${Math.round(1000 * message.seconds)} ms`
            : `Applied in ${short_number(message.seconds)} s`,
        );
      case "failed":
        if (message.what === "bake") this.dialogs.end_bake();
        if (message.what === "change") this.touch.restore();
        if (message.what === "beside" && this.beside) this.look.set_beside(this.beside);
        return this.notices.toast(message.what === "change" ? `Reverted: ${message.error}` : message.error, true);
      case "recorded":
        document.documentElement.dataset.recorded = message.position_hash;
        return this.notices.toast(
          `Recorded ${message.frames} frames in ${short_number(message.seconds)} s; ` +
            `hash of the last frame: ${message.position_hash}`,
        );
      case "saved":
        return this.dialogs.saved(message);
      case "baking":
        return this.dialogs.baking(message);
      case "baked":
        // Warnings from a bake stay until the next bake.
        this.bake_warnings = message.warnings.map((text) => ({ text: `Bake: ${text}`, places: [], vertices: [] }));
        this.list_warnings();
        return this.dialogs.baked(message);
      case "cancelled":
        this.dialogs.end_bake();
        return this.notices.toast("Stopped");
      case "refused":
        return this.notices.toast(message.error, true);
      default:
        return;
    }
  }

  private greet(hello: Hello): void {
    this.hello = hello;
    if (hello.protocol !== 1) {
      this.connection.close();
      fail(`This page uses protocol 1, but the program uses ${hello.protocol}. Reload the page.`);
      return;
    }
    show_hello(hello);
    if (hello.restored && hello.message) this.notices.toast(hello.message);
  }

  private array(message: ArrayMessage): void {
    // Paint does not belong to a body.
    if (message.name.startsWith("paint.")) return this.painter.array(message.name, message.items);
    if (!message.name.startsWith(BESIDE)) {
      this.arrays.set(message.name, message.items);
      return;
    }
    this.arrays_beside.set(message.name.slice(BESIDE.length), message.items);
    if (this.beside?.bake?.arrays.at(-1) === message.name) this.make_beside();
  }

  private async make_body(): Promise<void> {
    const body = this.body;
    if (!body) return;
    for (const name of [...this.arrays.keys()]) if (!body.arrays.includes(name)) this.arrays.delete(name);
    const looks = await this.loader.load(body, this.arrays);
    if (body !== this.body) return;
    this.loader.forget_all_but(this.arrays);
    this.picture.set_body(body, new Map(this.arrays), looks);
    this.look.set_body(body);
    this.bones.set_body(body, this.hello?.can_touch ?? false);
    this.make_beside();
    this.paint_stage();
    this.look.ask_for_blocks();
    this.refresh();
    document.documentElement.dataset.state = "ready";
  }

  // The bake's arrays follow the message.
  private set_beside(message: BesideMessage): void {
    const is_other = message.bake?.name !== this.beside?.bake?.name;
    this.beside = message;
    if (is_other && message.bake?.why_no_lag)
      this.notices.toast(`No lag for ${message.bake.name}: ${message.bake.why_no_lag}`);
    this.arrays_beside.clear();
    if (is_other || !message.bake) this.curves.clear_beside();
    if (!message.bake) this.make_beside();
  }

  private make_beside(): void {
    if (!this.beside || !this.picture.has_body) return;
    const has_all =
      this.beside.bake?.arrays.every((name) => this.arrays_beside.has(name.slice(BESIDE.length))) ?? false;
    this.picture.set_beside(has_all ? this.beside.bake : null, new Map(this.arrays_beside));
    this.look.set_beside(this.beside);
    this.look.ask_for_blocks();
    this.is_new = true;
  }

  private set_clip(clip: ClipMessage): void {
    if (!this.transport.set_clip(clip)) return;
    const axis = { fps: clip.fps, start: clip.start };
    const has_skeleton = (this.body?.counts.joints ?? 0) > 0;
    this.curves.begin(clip.frames + 1, axis, this.hello?.can_touch ?? false, has_skeleton);
  }

  private take_frame(frame: FrameMessage): void {
    // A frame of the previous body, sent before the new body.
    if (this.body && frame.body < this.body.body) return;
    this.frame = frame;
    this.look.note_rate(frame, this.transport.clip?.fps ?? 1, this.hello?.can_touch ?? false);
    this.curves.note(frame);
    this.is_new = true;
  }

  private lag_scale = 0; // m, of the picture shown
  private is_new = false; // whether the newest frame has not been shown yet

  private refresh(): void {
    this.is_new = false;
    if (!this.frame) return;
    let choice = this.look.choice();
    this.picture.show(this.frame, choice);
    // The colour scale depends on the maximum seen so far, which this frame may have raised.
    const { lag_scale } = (choice = this.look.choice());
    if (lag_scale !== this.lag_scale) this.picture.show(this.frame, choice);
    this.lag_scale = lag_scale;
    this.bones.mark();
    this.curves.draw(this.frame.frame);
    this.transport.show(this.frame);
    this.show_status();
    if (document.documentElement.dataset.state === "ready") {
      document.documentElement.dataset.sequence = String(this.frame.sequence);
      document.documentElement.dataset.hash = this.frame.hash;
    }
    this.look.show_words(choice);
  }

  private show_status(): void {
    if (document.documentElement.dataset.state !== "ready") return;
    const text = this.transport.status(this.hello?.can_touch !== false, this.frame?.begins ?? false);
    this.notices.set_status(text, "live");
  }

  // ---- User actions

  private send(type: string, members: object = {}): void {
    this.connection.command(type, members).then(
      (text) => this.notices.toast(text),
      (error: Error) => this.notices.toast(error.message, true),
    );
  }

  private looked(): void {
    this.look.ask_for_blocks();
    this.refresh();
    this.picture.stage.invalidate();
  }

  private list_warnings(): void {
    list_warnings([...this.bake_warnings, ...this.warnings], (place, vertex) =>
      this.picture.point_at(this.place_of(vertex) ?? place),
    );
  }

  // The current position of a vertex of the model, if frames contain it.
  private place_of(vertex: number | undefined): [number, number, number] | null {
    const vertices = this.frame?.blocks.vertices;
    if (vertex === undefined || !vertices || 3 * vertex + 2 >= vertices.length) return null;
    return [vertices[3 * vertex], vertices[3 * vertex + 1], vertices[3 * vertex + 2]];
  }

  // ---- Controls and keys

  private listen(): void {
    const on = (id: string, run: () => void) => element(id).addEventListener("click", run);
    on("undo", () => this.send("undo"));
    on("redo", () => this.send("redo"));
    this.transport.listen();
    this.look.listen();
    element("tab").addEventListener("change", () => {
      for (const id of ["touch", "wishes", "warnings"])
        element(id).hidden = !element("tab").querySelector<HTMLInputElement>(`input[value="${id}"]`)!.checked;
      if (element("warnings").hidden) this.picture.point_at_nothing();
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
      step_back: () => this.transport.step_back(),
      change_speed: (by) => this.transport.change_speed(by),
      tug: () => this.hand.tug(),
      dab: () => this.painter.dab(),
      resize_brush: (by) => this.painter.resize(by),
      help: () => help.showModal(),
    });
    fill_help(element("help-table"), groups);
    listen_to_keys(groups, () => document.querySelector("dialog[open]") !== null);
    // Ctrl+Z and Ctrl+Y as usual; text fields keep their own undo.
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
}

const token = location.hash.slice(1);
try {
  const studio = new Studio(`ws://${location.host}/live?token=${encodeURIComponent(token)}`);
  if (token === "") fail("The address has no token. Open the address that fascicle studio printed.");
  else studio.start();
} catch (error) {
  const reason = error instanceof Refused || error instanceof Error ? error.message : String(error);
  fail(`Cannot start the studio: ${reason}`);
}
