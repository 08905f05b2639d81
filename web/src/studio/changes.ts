// Sends changes of the scene's keys to the server.
import type { KeyValue } from "./protocol";

export interface ChangesUser {
  command(type: string, members: object): Promise<string>;
  refused(error: Error): void;
}

// While a change is in flight, only the latest further one waits. A change of another key sends the waiting one first.
export class Changes {
  private pending: { path: string; value: KeyValue; gesture: number | null } | null = null;
  private is_sending = false;

  constructor(private readonly user: ChangesUser) {}

  set(path: string, value: KeyValue, gesture: number | null): void {
    if (this.pending && this.pending.path !== path) this.flush();
    this.pending = { path, value, gesture };
    if (!this.is_sending) this.flush();
  }

  private flush(): void {
    const pending = this.pending;
    if (!pending) return;
    this.pending = null;
    this.is_sending = true;
    this.user
      .command("set", {
        changes: { [pending.path]: pending.value },
        ...(pending.gesture === null ? {} : { gesture: pending.gesture }),
      })
      .catch((error: Error) => this.user.refused(error))
      .finally(() => {
        this.is_sending = false;
        this.flush();
      });
  }
}
