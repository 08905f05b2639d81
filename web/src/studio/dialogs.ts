// The dialogs for saving the scene and for baking it.
import { element } from "../common/dom";
import { short_number } from "../common/numbers";
import type { Hello, ServerMessage } from "./protocol";

const FORMATS = ["pc2", "mdd", "glb", "abc", "usda", "obj", "vtu"];

// What the dialogs need from the page.
export interface DialogUser {
  hello(): Hello | null;
  command(type: string, members: object): Promise<string>;
  send(type: string): void;
  say(text: string): void;
}

// Consent to replace files is for one save or bake: a box that stayed ticked would give it for other names, too.
function take_consent(id: string): boolean {
  const box = element<HTMLInputElement>(id);
  const is_given = box.checked;
  box.checked = false;
  return is_given;
}

export class Dialogs {
  constructor(private readonly user: DialogUser) {}

  private open_save(): void {
    const hello = this.user.hello();
    element("save-error").textContent = "";
    element("save-note").textContent = hello ? `Folder: ${hello.folder}` : "";
    const name = element<HTMLInputElement>("save-name");
    if (!name.value && hello)
      name.value = `${hello.name.replaceAll(/[^A-Za-z0-9._-]/g, "_").replace(/\.toml$/, "")}.toml`;
    element<HTMLDialogElement>("save-dialog").showModal();
  }

  private async save(): Promise<void> {
    element("save-error").textContent = "";
    try {
      await this.user.command("save", {
        file: this.save_name(),
        overwrite: take_consent("save-over"),
      });
    } catch (error) {
      element("save-error").textContent = (error as Error).message;
    }
  }

  private async bake(): Promise<void> {
    element("bake-error").textContent = "";
    element("bake-files").replaceChildren();
    this.show_bake(true);
    try {
      await this.user.command("bake", {
        folder: element<HTMLInputElement>("bake-name").value,
        formats: [...document.querySelectorAll<HTMLInputElement>("#formats input:checked")].map((one) => one.value),
        overwrite: take_consent("bake-over"),
      });
    } catch (error) {
      element("bake-error").textContent = (error as Error).message;
      this.end_bake();
    }
  }

  private save_name(): string {
    const input = element<HTMLInputElement>("save-name");
    if (input.value && !input.value.endsWith(".toml")) input.value += ".toml";
    return input.value;
  }

  private show_bake(is_running: boolean): void {
    element("bake-progress").hidden = !is_running;
    element("bake-cancel").hidden = !is_running;
    element<HTMLButtonElement>("bake-go").disabled = is_running;
  }

  end_bake(): void {
    this.show_bake(false);
  }

  baked(message: Extract<ServerMessage, { type: "baked" }>): void {
    this.end_bake();
    const list = element("bake-files");
    list.replaceChildren();
    const add = (text: string) => {
      const item = document.createElement("li");
      item.textContent = text;
      list.append(item);
      return item;
    };
    const seconds = short_number(message.seconds);
    add(`${message.frames} frames in ${seconds} s; hash of the last frame: ${message.position_hash}`);
    for (const warning of message.warnings) add(warning).className = "warning";
    for (const file of message.files) add(`${message.folder}/${file}`);
    document.documentElement.dataset.baked = message.position_hash;
    this.user.say(`Baked to ${message.folder}`);
  }

  saved(message: Extract<ServerMessage, { type: "saved" }>): void {
    element("save-note").textContent =
      `Saved ${message.file}${message.kept_comments ? "" : " without comments"}. ${message.message}`;
    this.user.say(`Saved ${message.file}`);
    document.documentElement.dataset.saved = message.file;
  }

  baking(message: Extract<ServerMessage, { type: "baking" }>): void {
    // Also for a page that did not begin the bake: a reloaded one, or another.
    this.show_bake(true);
    const before = message.phase === "build" ? "Building the body" : "Running the lead-in";
    element("bake-phase").textContent =
      message.phase === "frames" ? `Frame ${message.frame} of ${message.frames}` : before;
    element<HTMLProgressElement>("bake-bar").value = message.frames > 0 ? message.frame / message.frames : 0;
  }

  listen(): void {
    const on = (id: string, run: () => void) => element(id).addEventListener("click", run);
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
    on("bake-cancel", () => this.user.send("cancel"));
    element("bake-form").addEventListener("submit", (event) => {
      event.preventDefault();
      void this.bake();
    });
  }
}
