// The studio's keyboard shortcuts: one for each control.
import { choose, choose_next, element, say, toggle } from "../common/dom";
import type { BindingGroup } from "../common/keys";
import type { Orbit } from "../common/orbit";

// Actions without a control on the page.
export interface Actions {
  step_back(): void;
  change_speed(by: number): void;
  tug(): void;
  dab(): void;
  resize_brush(by: number): void;
  help(): void;
}

export function bindings(orbit: Orbit, does: Actions): BindingGroup[] {
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
      title: "Playback",
      bindings: [
        { keys: [" "], shown: "Space", does: "Play or pause", run: click("play") },
        { keys: ["ArrowRight"], shown: "→", does: "Next frame", run: click("forward") },
        { keys: ["ArrowLeft"], shown: "←", does: "Previous frame", run: () => does.step_back() },
        { keys: ["Home"], shown: "Home", does: "Restart", run: click("restart") },
        { keys: ["l"], shown: "L", does: "Loop", run: click("loop") },
        { keys: ["["], shown: "[", does: "Slower", run: () => does.change_speed(-1) },
        { keys: ["]"], shown: "]", does: "Faster", run: () => does.change_speed(1) },
        { keys: ["q"], shown: "Q", does: "Start or stop recording", run: click("record") },
      ],
    },
    {
      title: "Edit",
      bindings: [
        { keys: ["1"], shown: "1", does: "Parameters", run: () => choose("tab", "touch") },
        { keys: ["2"], shown: "2", does: "Presets", run: () => choose("tab", "wishes") },
        { keys: ["3"], shown: "3", does: "Warnings", run: () => choose("tab", "warnings") },
        {
          keys: ["/"],
          shown: "/",
          does: "Find a parameter",
          run: () => { choose("tab", "touch"); element("find").focus(); },
        },
        { keys: ["z"], shown: "Z", does: "Undo", run: click("undo") },
        { keys: ["y"], shown: "Y", does: "Redo", run: click("redo") },
        { keys: ["x"], shown: "X", does: "Save", run: click("save") },
        { keys: ["k"], shown: "K", does: "Bake", run: click("bake") },
        { keys: ["h"], shown: "H", does: "Next tool: orbit, pull, paint, bones", run: () => choose_next("tool") },
        { keys: ["p"], shown: "P", does: "Pull at the centre of the view", run: () => does.tug() },
        { keys: ["g"], shown: "G", does: "Paint at the centre of the view", run: () => does.dab() },
        { keys: ["f"], shown: "F", does: "Smaller brush", run: () => does.resize_brush(-4) },
        { keys: ["v"], shown: "V", does: "Larger brush", run: () => does.resize_brush(4) },
      ],
    },
    {
      title: "Display",
      bindings: [
        { keys: ["m"], shown: "M", does: "Next colouring", run: () => next_option("colour", 1) },
        { keys: ["c"], shown: "C", does: "Flesh, ghost or both", run: () => choose_next("comparison") },
        { keys: ["Shift+b"], shown: "Shift B", does: "Next bake to compare", run: () => next_option("against", 1) },
        { keys: ["b"], shown: "B", does: "Skin or tetrahedra", run: () => choose_next("body") },
        {
          keys: ["u"],
          shown: "U",
          does: "Next cut axis",
          run: () => { choose("body", "tetrahedra"); next_option("cut-axis", 1); },
        },
        { keys: [","], shown: ",", does: "Move cut back", run: () => move_range("cut", -2) },
        { keys: ["."], shown: ".", does: "Move cut forward", run: () => move_range("cut", 2) },
        { keys: ["i"], shown: "I", does: "Fibres", run: () => toggle("fibres") },
        { keys: ["j"], shown: "J", does: "Skeleton", run: () => toggle("skeleton") },
        { keys: ["o"], shown: "O", does: "Inverted tetrahedra", run: () => toggle("inverted") },
        { keys: ["e"], shown: "E", does: "Edges", run: () => toggle("edges") },
        { keys: ["Shift+c"], shown: "Shift C", does: "Solids", run: () => toggle("solids") },
        { keys: ["n"], shown: "N", does: "Floor", run: () => toggle("floor") },
      ],
    },
    {
      title: "View",
      bindings: [
        { keys: ["a"], shown: "A", does: "Orbit left", run: () => orbit.turn(0.12, 0) },
        { keys: ["d"], shown: "D", does: "Orbit right", run: () => orbit.turn(-0.12, 0) },
        { keys: ["w"], shown: "W", does: "Orbit up", run: () => orbit.turn(0, 0.1) },
        { keys: ["s"], shown: "S", does: "Orbit down", run: () => orbit.turn(0, -0.1) },
        { keys: ["Shift+a"], shown: "Shift A", does: "Pan left", run: () => orbit.pan(0.05, 0) },
        { keys: ["Shift+d"], shown: "Shift D", does: "Pan right", run: () => orbit.pan(-0.05, 0) },
        { keys: ["Shift+w"], shown: "Shift W", does: "Pan up", run: () => orbit.pan(0, 0.05) },
        { keys: ["Shift+s"], shown: "Shift S", does: "Pan down", run: () => orbit.pan(0, -0.05) },
        { keys: ["+", "="], shown: "+", does: "Zoom in", run: () => orbit.zoom(1.15) },
        { keys: ["-"], shown: "−", does: "Zoom out", run: () => orbit.zoom(1 / 1.15) },
        { keys: ["r"], shown: "R", does: "Reset view", run: () => orbit.reset() },
      ],
    },
    {
      title: "Page",
      bindings: [
        { keys: ["t"], shown: "T", does: "Dark or light theme", run: click("theme") },
        { keys: ["?"], shown: "?", does: "Keyboard shortcuts", run: () => does.help() },
      ],
    },
  ];
}
