// The page of `fascicle view`: shows a finished bake.
import { Box3, Vector3 } from "three";
import { Body, BodyMaterials, load_textures } from "../common/body";
import type { Colouring, Looks } from "../common/body";
import { SCALE } from "../common/colours";
import { CurvePlot, value_text } from "../common/curves";
import type { Lane } from "../common/curves";
import { add_fact, checked, choose, choose_next, element, say, toggle } from "../common/dom";
import { Film } from "../common/film";
import type { Curve, Description } from "../common/film";
import { fill_help, listen_to_keys } from "../common/keys";
import type { BindingGroup } from "../common/keys";
import { grouped, in_full, nice_above, short_number } from "../common/numbers";
import { VIEWS } from "../common/orbit";
import { Player } from "../common/player";
import { FIELD, Stage } from "../common/stage";
import { follow_theme, style_value } from "../common/theme";

const MOST_LANES = 4;
const MOST_SAMPLES = 60000; // number of sampled points, over all frames, that the camera and the scale are
                            // fitted to
const SLICE = 24; // ms of decoding before yielding to the page
const PLAY = "M4 2.5v11L13.5 8z";
const PAUSE = "M3.5 2.5h3.2v11H3.5zM9.3 2.5h3.2v11H9.3z";

class Viewer {
  private readonly film: Film;
  private readonly player: Player;
  private readonly stage: Stage;
  private readonly places: Float32Array;
  private readonly lag: Float32Array;
  private readonly is_beside: Uint8Array; // 1 for a place on the surroundings
  private readonly centre: [number, number, number];
  private readonly middles: Vector3[] = []; // per frame, m from the centre
  private flesh!: Body;
  private ghost!: Body;
  private plot!: CurvePlot;
  private lanes: Lane[] = [];
  private most_lag = 1e-3; // m, exceeded by few places in any frame
  private shown = -1;
  private last_tick = 0;

  constructor(private readonly description: Description) {
    this.film = new Film(description);
    this.player = new Player(description.frames, description.fps);
    this.stage = new Stage(element<HTMLCanvasElement>("picture"));
    this.places = new Float32Array(3 * description.places);
    this.lag = new Float32Array(description.places);
    this.is_beside = new Uint8Array(description.places);
    for (const place of description.surroundings) this.is_beside[place] = 1;
    this.film.decode_next();
    this.centre = this.middle_of(this.film.flesh[0], [0, 0, 0]);
  }

  private middle_of(cells: Int32Array, from: readonly number[]): [number, number, number] {
    const sum = [0, 0, 0];
    for (let k = 0; k < cells.length; ++k) if (!this.is_beside[Math.floor(k / 3)]) sum[k % 3] += cells[k];
    const { origin, step, places, surroundings } = this.description;
    const count = places - surroundings.length;
    return [0, 1, 2].map((c) => origin[c] + (step * sum[c]) / count - from[c]) as [number, number, number];
  }

  async start(): Promise<void> {
    const { description, film, stage } = this;
    const looks: Looks = { ...description, textures: await load_textures(description.textures) };
    const materials = new BodyMaterials(looks, description.has_colours);
    this.flesh = new Body(film.surface, looks, materials);
    this.ghost = new Body(film.surface, looks, materials);
    stage.scene.add(this.ghost.group, this.flesh.group);
    this.describe();
    await this.decode();
    this.furnish();
    this.plot = new CurvePlot(element<HTMLCanvasElement>("plot"), film.frames, (frame) => this.seek(frame));
    this.list_curves();
    this.listen();
    follow_theme(() => this.repaint());
    window.addEventListener("resize", () => {
      stage.invalidate();
      this.plot.draw(this.lanes, this.player.frame);
    });
    this.show();
    element("loading").hidden = true;
    this.play();
    requestAnimationFrame((now) => this.tick(now));
    document.documentElement.dataset.state = "ready";
  }

  // Decodes all frames in slices, so that the page stays responsive.
  private async decode(): Promise<void> {
    const { film } = this;
    const bar = element<HTMLProgressElement>("loaded");
    for (let more = true; more; ) {
      const until = performance.now() + SLICE;
      while (more && performance.now() < until) more = film.decode_next();
      bar.value = film.flesh.length / film.frames;
      await new Promise((done) => setTimeout(done));
    }
    const sample = Math.ceil((film.frames * this.lag.length) / MOST_SAMPLES);
    const lags: number[] = [];
    for (let k = 0; k < film.frames; ++k) {
      this.middles.push(new Vector3(...this.middle_of(film.flesh[k], this.centre)));
      film.lag(k, this.lag);
      for (let p = k % sample; p < this.lag.length; p += sample) lags.push(this.lag[p]);
    }
    lags.sort((a, b) => a - b);
    const high = lags[Math.floor(0.998 * (lags.length - 1))] || 1e-3;
    this.most_lag = nice_above(high, [1, 1.5, 2, 3, 4, 5, 6, 8, 10]);
  }

  // Fits the camera to the whole motion or, if the body travels far, to the body as it moves.
  private furnish(): void {
    const { film, stage } = this;
    const all = new Box3();
    const own = new Box3(); // relative to the body's own middle
    const point = new Vector3();
    let lowest = Infinity; // of the surroundings, too
    const each = (use: (frame: number) => void) =>
      film.flesh.forEach((cells, k) => {
        const places = film.places(cells, this.centre, this.places);
        for (let p = 0; p < places.length; p += 3) {
          lowest = Math.min(lowest, places[p + 1]);
          if (this.is_beside[p / 3]) continue;
          point.fromArray(places, p);
          use(k);
        }
      });
    each((k) => {
      all.expandByPoint(point);
      own.expandByPoint(point.sub(this.middles[k]));
    });
    const size = (box: Box3) => box.min.distanceTo(box.max);
    const goes_far = size(all) > 1.6 * size(own);
    element<HTMLInputElement>("follow").checked = goes_far;
    const middle = (goes_far ? own : all).getCenter(new Vector3());
    const sample = Math.ceil((film.frames * this.description.places) / MOST_SAMPLES);
    const points: number[] = [];
    let number = 0;
    let square = 0;
    each((k) => {
      if (goes_far) point.sub(this.middles[k]);
      point.sub(middle);
      square = Math.max(square, point.lengthSq());
      if (number++ % sample === 0) points.push(point.x, point.y, point.z);
    });
    stage.furnish(middle, Math.sqrt(square) || 1, lowest);
    const canvas = element("picture");
    stage.orbit.frame(middle, points, FIELD, canvas.clientWidth / Math.max(canvas.clientHeight, 1));
  }

  private describe(): void {
    const { description } = this;
    const seconds = (description.frames - 1) / description.fps;
    element("subtitle").textContent =
      `${grouped(description.frames)} frames at ${in_full(description.fps)} fps, ` +
      `${grouped(description.bake_vertices)} vertices`;
    const facts = element("facts");
    add_fact(facts, "Duration", `${in_full(seconds)} s`);
    add_fact(facts, "Surface", description.surface);
    add_fact(facts, "Triangles", grouped(description.triangles));
    add_fact(facts, "Tetrahedra", grouped(description.tetrahedra));
    if (description.device) add_fact(facts, "Baked on", description.device);
    add_fact(facts, "Baked with", description.program);
    add_fact(facts, "Quantisation error", `up to ${short_number(1005 * description.error)} mm`);
    const warnings = element("warnings");
    for (const text of description.warnings) {
      const item = document.createElement("li");
      item.textContent = text;
      warnings.append(item);
    }
    warnings.hidden = description.warnings.length === 0;
    element("ghost-name").textContent = description.ghost === "skinning" ? "skinning alone" : "the rest shape";
    if (!description.painted) {
      document.querySelector('input[value="materials"] + span')!.textContent = "Plain";
    }
    element<HTMLInputElement>("scrub").max = String(description.frames - 1);
  }

  private list_curves(): void {
    const { curves } = this.description;
    const list = element("curve-list");
    const lags = curves.filter((curve) => curve.name.startsWith("Lag of "));
    const largest = (curve: Curve) => Math.max(...curve.values.map((value) => value ?? 0));
    const most = lags.reduce<Curve | null>((best, one) => (!best || largest(one) > largest(best) ? one : best), null);
    const first = [most, ...curves.filter((curve) => !lags.includes(curve))].filter((one) => one).slice(0, MOST_LANES);
    curves.forEach((curve, number) => {
      const colour = `--curve-${number % 6}`;
      const label = document.createElement("label");
      const box = document.createElement("input");
      box.type = "checkbox";
      box.checked = first.includes(curve);
      const line = document.createElement("span");
      line.className = "line";
      line.style.background = `var(${colour})`;
      const name = document.createElement("span");
      name.textContent = curve.name;
      const value = document.createElement("output");
      label.append(box, line, name, value);
      const item = document.createElement("li");
      item.append(label);
      list.append(item);
      const lane: Lane = { curve, colour };
      if (box.checked) this.lanes.push(lane);
      box.addEventListener("change", () => {
        this.lanes = this.lanes.filter((one) => one !== lane);
        if (box.checked) this.lanes.push(lane);
        this.plot.draw(this.lanes, this.player.frame);
      });
    });
    element("curves").hidden = curves.length === 0;
  }

  private listen(): void {
    const { player, stage } = this;
    const on = (id: string, run: () => void) => element(id).addEventListener("click", run);
    on("play", () => (player.playing ? this.pause() : this.play()));
    on("first", () => this.seek(0));
    on("last", () => this.seek(player.last));
    on("back", () => this.step(-1));
    on("forward", () => this.step(1));
    const scrub = element<HTMLInputElement>("scrub");
    scrub.addEventListener("input", () => this.seek(Number(scrub.value)));
    const loop = element<HTMLInputElement>("loop");
    loop.addEventListener("change", () => (player.loops = loop.checked));
    const speed = element<HTMLSelectElement>("speed");
    speed.addEventListener("change", () => (player.speed = Number(speed.value)));
    for (const id of ["colouring", "comparison"])
      element(id).addEventListener("change", (event) => {
        if ((event.target as HTMLInputElement).type !== "radio") return;
        say((event.target as HTMLElement).nextElementSibling?.textContent ?? "");
        this.show();
      });
    element("lag-scale").addEventListener("input", () => this.show());
    element("follow").addEventListener("change", () => this.show());
    element("edges").addEventListener("change", () => this.show());
    const floor = element<HTMLInputElement>("floor");
    floor.addEventListener("change", () => stage.show_floor(floor.checked));
    element("views").addEventListener("click", (event) => {
      const view = (event.target as HTMLElement).dataset.view;
      if (view) stage.orbit.look(VIEWS[view]);
    });
    const help = element<HTMLDialogElement>("help");
    on("help-open", () => help.showModal());
    on("help-close", () => help.close());
    const groups = this.bindings(help);
    fill_help(element("help-table"), groups);
    listen_to_keys(groups, () => help.open);
  }

  private bindings(help: HTMLDialogElement): BindingGroup[] {
    const { player, stage } = this;
    const speed = element<HTMLSelectElement>("speed");
    const change_speed = (by: number) => {
      speed.selectedIndex = Math.min(Math.max(speed.selectedIndex + by, 0), speed.options.length - 1);
      speed.dispatchEvent(new Event("change"));
      say(`Speed ${speed.value}×`);
    };
    const change_scale = (factor: number) => {
      choose("colouring", "lag");
      const input = element<HTMLInputElement>("lag-scale");
      input.value = String(Number(input.value) + factor);
      input.dispatchEvent(new Event("input"));
    };
    let view = 0;
    const names = Object.keys(VIEWS);
    return [
      {
        title: "Playback",
        bindings: [
          { keys: [" "], shown: "Space", does: "Play or pause", run: () => (player.playing ? this.pause() : this.play()) },
          { keys: ["ArrowLeft"], shown: "←", does: "Previous frame", run: () => this.step(-1) },
          { keys: ["ArrowRight"], shown: "→", does: "Next frame", run: () => this.step(1) },
          { keys: ["Shift+ArrowLeft"], shown: "Shift ←", does: "Back ten frames", run: () => this.step(-10) },
          { keys: ["Shift+ArrowRight"], shown: "Shift →", does: "Forward ten frames", run: () => this.step(10) },
          { keys: ["Home"], shown: "Home", does: "First frame", run: () => this.seek(0) },
          { keys: ["End"], shown: "End", does: "Last frame", run: () => this.seek(player.last) },
          { keys: ["l"], shown: "L", does: "Loop", run: () => toggle("loop") },
          { keys: ["["], shown: "[", does: "Slower", run: () => change_speed(-1) },
          { keys: ["]"], shown: "]", does: "Faster", run: () => change_speed(1) },
        ],
      },
      {
        title: "Display",
        bindings: [
          { keys: ["1"], shown: "1", does: "Materials", run: () => choose("colouring", "materials") },
          { keys: ["2"], shown: "2", does: "Layers", run: () => choose("colouring", "layers") },
          { keys: ["3"], shown: "3", does: "Lag", run: () => choose("colouring", "lag") },
          { keys: [","], shown: ",", does: "Decrease lag scale", run: () => change_scale(-5) },
          { keys: ["."], shown: ".", does: "Increase lag scale", run: () => change_scale(5) },
          { keys: ["c"], shown: "C", does: "Flesh, ghost or side by side", run: () => choose_next("comparison") },
          { keys: ["g"], shown: "G", does: "Ghost", run: () => choose("comparison", "ghost") },
          { keys: ["b"], shown: "B", does: "Side by side", run: () => choose("comparison", "sides") },
          { keys: ["e"], shown: "E", does: "Edges", run: () => toggle("edges") },
          { keys: ["n"], shown: "N", does: "Floor", run: () => toggle("floor") },
        ],
      },
      {
        title: "View",
        bindings: [
          { keys: ["a"], shown: "A", does: "Orbit left", run: () => stage.orbit.turn(0.12, 0) },
          { keys: ["d"], shown: "D", does: "Orbit right", run: () => stage.orbit.turn(-0.12, 0) },
          { keys: ["w"], shown: "W", does: "Orbit up", run: () => stage.orbit.turn(0, 0.1) },
          { keys: ["s"], shown: "S", does: "Orbit down", run: () => stage.orbit.turn(0, -0.1) },
          { keys: ["Shift+a"], shown: "Shift A", does: "Pan left", run: () => stage.orbit.pan(0.05, 0) },
          { keys: ["Shift+d"], shown: "Shift D", does: "Pan right", run: () => stage.orbit.pan(-0.05, 0) },
          { keys: ["Shift+w"], shown: "Shift W", does: "Pan up", run: () => stage.orbit.pan(0, 0.05) },
          { keys: ["Shift+s"], shown: "Shift S", does: "Pan down", run: () => stage.orbit.pan(0, -0.05) },
          { keys: ["+", "="], shown: "+", does: "Zoom in", run: () => stage.orbit.zoom(1.15) },
          { keys: ["-"], shown: "−", does: "Zoom out", run: () => stage.orbit.zoom(1 / 1.15) },
          {
            keys: ["v"],
            shown: "V",
            does: "Next view",
            run: () => {
              view = (view + 1) % names.length;
              stage.orbit.look(VIEWS[names[view]]);
              say(names[view]);
            },
          },
          { keys: ["r"], shown: "R", does: "Reset view", run: () => stage.orbit.reset() },
          { keys: ["f"], shown: "F", does: "Follow body", run: () => toggle("follow") },
        ],
      },
      {
        title: "Page",
        bindings: [
          { keys: ["t"], shown: "T", does: "Dark or light theme", run: () => toggle("theme") },
          { keys: ["?"], shown: "?", does: "Keyboard shortcuts", run: () => help.showModal() },
        ],
      },
    ];
  }

  private play(): void {
    this.player.play();
    this.last_tick = performance.now();
    this.show();
  }

  private pause(): void {
    this.player.pause();
    this.show();
  }

  private seek(frame: number): void {
    this.player.pause();
    this.player.show(frame);
    this.show();
  }

  private step(by: number): void {
    this.player.step(by);
    this.show();
  }

  private repaint(): void {
    this.stage.paint(style_value("--stage"), style_value("--grid"), Number(style_value("--grid-opacity")));
    if (this.shown >= 0) this.show();
  }

  private lag_scale(): number {
    return (this.most_lag * Math.max(Number(element<HTMLInputElement>("lag-scale").value), 1)) / 100;
  }

  // Updates everything that depends on the frame and on the user's choices.
  private show(): void {
    const { film, player, stage, description } = this;
    const { frame } = player;
    const colouring = checked("colouring") as Colouring;
    const comparison = checked("comparison");
    const lag = colouring === "lag" ? film.lag(frame, this.lag) : null;
    this.flesh.move(film.places(film.flesh[frame], this.centre, this.places));
    this.flesh.colour(colouring, lag, this.lag_scale());
    if (comparison !== "flesh") {
      this.ghost.move(film.places(film.ghost_of(frame), this.centre, this.places));
      if (comparison === "ghost") {
        this.ghost.haunt();
      } else {
        this.ghost.stand();
        this.ghost.colour(colouring, null, 1);
      }
    }
    const edges = element<HTMLInputElement>("edges").checked;
    this.flesh.show_edges(edges);
    this.ghost.show_edges(edges && comparison === "sides");
    const follows = element<HTMLInputElement>("follow").checked;
    stage.orbit.carried.copy(follows ? this.middles[frame] : new Vector3());
    stage.light_up(new Vector3().addVectors(stage.orbit.target, stage.orbit.carried));
    stage.invalidate();
    this.shown = frame;
    this.show_words(colouring, comparison);
    this.plot.draw(this.lanes, frame);
    const values = element("curve-list").querySelectorAll("output");
    description.curves.forEach((curve, k) => (values[k].textContent = value_text(curve, frame)));
  }

  private show_words(colouring: Colouring, comparison: string): void {
    const { player, description } = this;
    const number = description.first_number + player.frame;
    const seconds = description.start + player.frame / description.fps;
    const text = `Frame ${number} of ${description.first_number + player.last}, ${seconds.toFixed(3)} s`;
    const scrub = element<HTMLInputElement>("scrub");
    scrub.value = String(player.frame);
    scrub.setAttribute("aria-valuetext", text);
    element("clock").textContent = `${number} / ${description.first_number + player.last}   ${seconds.toFixed(3)} s`;
    element("play").setAttribute("aria-label", player.playing ? "Pause" : "Play");
    element("play-sign").setAttribute("d", player.playing ? PAUSE : PLAY);
    const sides = comparison === "sides";
    const ghost = description.ghost === "skinning" ? "Skinning alone" : "Rest shape";
    element("tag-left").hidden = !sides && comparison !== "ghost";
    element("tag-left").textContent = sides ? ghost : `Blue: ${ghost.toLowerCase()}`;
    element("tag-right").hidden = !sides;
    element("tag-right").textContent = "Flesh";
    element("lag-row").hidden = colouring !== "lag";
    const millimetres = `${short_number(1e3 * this.lag_scale())} mm`;
    element("lag-text").textContent = millimetres;
    this.show_legend(colouring, millimetres);
  }

  private legend_shown = "";
  private show_legend(colouring: Colouring, millimetres: string): void {
    const key = colouring === "lag" ? millimetres : colouring;
    if (key === this.legend_shown) return;
    this.legend_shown = key;
    const legend = element("legend");
    legend.replaceChildren();
    legend.hidden = colouring === "materials";
    const entry = (text: string, sign: HTMLElement | null) => {
      const item = document.createElement("span");
      if (sign) item.append(sign);
      item.append(text);
      legend.append(item);
    };
    if (colouring === "layers") {
      for (const layer of this.description.layers) {
        const swatch = document.createElement("i");
        swatch.className = "swatch";
        swatch.style.background = layer.colour;
        entry(layer.name, swatch);
      }
    } else if (colouring === "lag") {
      const scale = document.createElement("i");
      scale.className = "scale";
      scale.style.background = `linear-gradient(to right, ${SCALE.join(", ")})`;
      entry("0", null);
      legend.append(scale);
      entry(millimetres, null);
    }
  }

  private tick(now: number): void {
    // A frame's timestamp may be earlier than the click that started playback.
    const seconds = Math.min(Math.max(now - this.last_tick, 0) / 1000, 0.25);
    this.last_tick = now;
    if (this.player.advance(seconds)) this.show();
    const sides = checked("comparison") === "sides";
    const { flesh, ghost, stage } = this;
    if (sides)
      stage.render([
        { shown: [ghost.group], hidden: [flesh.group] },
        { shown: [flesh.group], hidden: [ghost.group] },
      ]);
    else if (checked("comparison") === "ghost") stage.render([{ shown: [flesh.group, ghost.group], hidden: [] }]);
    else stage.render([{ shown: [flesh.group], hidden: [ghost.group] }]);
    requestAnimationFrame((next) => this.tick(next));
  }
}

function fail(error: unknown): void {
  element("loading").hidden = true;
  const failure = element("failure");
  failure.hidden = false;
  failure.textContent = `Cannot show this page: ${error instanceof Error ? error.message : String(error)}`;
  document.documentElement.dataset.state = "failed";
}

try {
  const description = JSON.parse(element("bake").textContent ?? "") as Description;
  new Viewer(description).start().catch(fail);
} catch (error) {
  fail(error);
}
