// Playback clock: the frame to show at a given time.

export class Player {
  frame = 0;
  playing = false;
  loops = true;
  speed = 1;
  private elapsed = 0; // s of motion since the frame shown began

  constructor(
    public frames: number,
    public fps: number,
  ) {}

  get last(): number {
    return this.frames - 1;
  }

  // Restarts if it is at the end.
  play(): void {
    if (this.frame >= this.last) this.frame = 0;
    this.elapsed = 0;
    this.playing = this.frames > 1;
  }

  pause(): void {
    this.playing = false;
  }

  show(frame: number): void {
    this.frame = Math.min(Math.max(Math.round(frame), 0), this.last);
    this.elapsed = 0;
  }

  // Wraps around if it loops.
  step(by: number): void {
    this.pause();
    const to = this.frame + by;
    this.show(this.loops && Math.abs(by) === 1 ? (to + this.frames) % this.frames : to);
  }

  // `seconds` of wall-clock time have passed. True if the frame changed.
  advance(seconds: number): boolean {
    if (!this.playing) return false;
    this.elapsed += seconds * this.speed;
    const steps = Math.floor(this.elapsed * this.fps + 1e-6);
    if (steps === 0) return false;
    this.elapsed -= steps / this.fps;
    const to = this.frame + steps;
    if (to <= this.last) {
      this.frame = to;
    } else if (this.loops) {
      this.frame = to % this.frames;
    } else {
      this.frame = this.last;
      this.pause();
    }
    return true;
  }
}
