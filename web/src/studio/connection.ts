// The WebSocket to the studio's server, which reconnects automatically.
import type { ServerMessage } from "./protocol";
import type { ArrayMessage, FrameMessage } from "./wire";
import { read_array, read_frame } from "./wire";

export interface Listener {
  opened(): void;
  lost(): void;
  said(message: ServerMessage): void;
  array(message: ArrayMessage): void;
  frame(message: FrameMessage): void;
}

const FIRST_WAIT = 300; // ms
const LONGEST_WAIT = 3000;

export class Refused extends Error {}

export class Connection {
  private socket: WebSocket | null = null;
  private next_id = 1;
  private wait = FIRST_WAIT;
  private readonly waiting = new Map<number, { done: (text: string) => void; refused: (error: Error) => void }>();

  // `address`: with the token that the program printed.
  constructor(
    private readonly address: string,
    private readonly listener: Listener,
  ) {}

  open(): void {
    const socket = new WebSocket(this.address);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.addEventListener("open", () => {
      this.wait = FIRST_WAIT;
      this.listener.opened();
    });
    socket.addEventListener("message", (event: MessageEvent<string | ArrayBuffer>) => this.receive(event.data));
    socket.addEventListener("close", () => {
      if (this.socket !== socket) return;
      this.socket = null;
      for (const one of this.waiting.values()) one.refused(new Refused("connection to fascicle studio lost"));
      this.waiting.clear();
      this.listener.lost();
      setTimeout(() => this.open(), this.wait);
      this.wait = Math.min(2 * this.wait, LONGEST_WAIT);
    });
  }

  private receive(data: string | ArrayBuffer): void {
    if (typeof data !== "string") {
      const kind = new Uint8Array(data, 0, 1)[0];
      if (kind === 1) this.listener.frame(read_frame(data));
      else this.listener.array(read_array(data));
      return;
    }
    const message = JSON.parse(data) as ServerMessage;
    if ((message.type === "done" || message.type === "refused") && message.id !== undefined) {
      const one = this.waiting.get(message.id);
      this.waiting.delete(message.id);
      if (message.type === "done") one?.done(message.message ?? "");
      else one?.refused(new Refused(message.error));
      return;
    }
    this.listener.said(message);
  }

  // Closes without reconnecting.
  close(): void {
    const socket = this.socket;
    this.socket = null;
    socket?.close();
  }

  // Resolves to the server's reply; throws Refused with the reason.
  command(type: string, members: object = {}): Promise<string> {
    const socket = this.socket;
    if (!socket || socket.readyState !== WebSocket.OPEN)
      return Promise.reject(new Refused("not connected to fascicle studio"));
    const id = this.next_id++;
    return new Promise((done, refused) => {
      this.waiting.set(id, { done, refused });
      socket.send(JSON.stringify({ type, id, ...members }));
    });
  }
}
