// The timeline's controls: play, seek, speed, record.
import { element, say } from "../common/dom";
import type { ClipMessage, PlayerMessage } from "./protocol";
import type { FrameMessage } from "./wire";

const PLAY = "M4 2.5v11L13.5 8z";
const PAUSE = "M3.5 2.5h3.2v11H3.5zM9.3 2.5h3.2v11H9.3z";

export class Transport {
  clip: ClipMessage | null = null;
  player: PlayerMessage | null = null;
  private frame = 0; // the current one

  constructor(private readonly send: (type: string, members?: object) => void) {}

  // Whether frames arrive by themselves.
  get moves(): boolean {
    return this.player?.state === "playing" || this.player?.state === "recording";
  }

  // True if the clip is another one.
  set_clip(clip: ClipMessage): boolean {
    const before = this.clip;
    this.clip = clip;
    element<HTMLInputElement>("scrub").max = String(clip.frames);
    return before?.frames !== clip.frames || before.fps !== clip.fps || before.start !== clip.start;
  }

  set_player(player: PlayerMessage): void {
    this.player = player;
    element("play").setAttribute("aria-label", this.moves ? "Pause" : "Play");
    element("play-sign").setAttribute("d", this.moves ? PAUSE : PLAY);
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

  show(frame: FrameMessage): void {
    this.frame = frame.frame;
    const clock = this.clip ? `${frame.frame} / ${this.clip.frames}   ${frame.time.toFixed(3)} s` : "";
    element("clock").textContent = clock;
    const scrub = element<HTMLInputElement>("scrub");
    if (document.activeElement !== scrub || this.player?.state === "playing") scrub.value = String(frame.frame);
    scrub.setAttribute("aria-valuetext", `Frame ${clock}`);
  }

  // The status text. `begins`: the flesh was just carried here along the skeleton.
  status(can_touch: boolean, begins: boolean): string {
    if (this.player?.message) return this.player.message;
    switch (this.player?.state) {
      case "recording":
        return "Recording";
      case "baking":
        return "Baking";
      case "paused":
        return begins && can_touch ? "Paused; play to simulate from here" : "Paused";
      default:
        return can_touch ? "Live" : "Playing";
    }
  }

  seek(frame: number): void {
    this.send("seek", { frame: Math.min(Math.max(Math.round(frame), 0), this.clip?.frames ?? 0) });
  }
  step_back(): void {
    this.seek(this.frame - 1);
  }

  change_speed(by: number): void {
    const speed = element<HTMLSelectElement>("speed");
    speed.selectedIndex = Math.min(Math.max(speed.selectedIndex + by, 0), speed.options.length - 1);
    speed.dispatchEvent(new Event("change"));
    say(`Speed ${speed.value}×`);
  }

  listen(): void {
    const on = (id: string, run: () => void) => element(id).addEventListener("click", run);
    on("play", () => this.send(this.player?.state === "playing" ? "pause" : "play"));
    on("forward", () => this.send("step"));
    on("restart", () => this.send("restart"));
    on("record", () => this.send(this.player?.state === "recording" ? "cancel" : "record"));
    const scrub = element<HTMLInputElement>("scrub");
    scrub.addEventListener("input", () => this.seek(Number(scrub.value)));
    const loop = element<HTMLInputElement>("loop");
    loop.addEventListener("change", () => this.send("loop", { on: loop.checked }));
    const speed = element<HTMLSelectElement>("speed");
    speed.addEventListener("change", () => this.send("speed", { factor: Number(speed.value) }));
  }
}
