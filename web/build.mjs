// Bundles the pages into the folder that is given: `node build.mjs bundle`. Everything of the page view is in one file;
// its content security policy names its script and its style by their hashes, and allows nothing else. The studio's
// page is three files, which its server sends with a policy of its own.
import { createHash } from "node:crypto";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const home = dirname(fileURLToPath(import.meta.url));
const out = join(process.cwd(), process.argv[2] ?? "bundle");

async function bundled(options) {
  const result = await build({
    absWorkingDir: home,
    bundle: true,
    write: false,
    minify: true,
    charset: "ascii",
    legalComments: "none",
    target: ["es2022"],
    ...options,
  });
  return result.outputFiles[0].text.trim();
}

// three.js asks that its notice goes with every copy.
function notice() {
  const licence = readFileSync(join(home, "node_modules/three/LICENSE"), "utf8").trim();
  return `/* three.js, https://threejs.org\n\n${licence}\n*/\n`;
}

const hash = (text) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;

async function one_file(name) {
  const script = notice() + (await bundled({ entryPoints: [`src/${name}/main.ts`], format: "iife" }));
  const style = await bundled({ entryPoints: ["src/common/style.css"] });
  if (/<\/script|<!--|\)fascicle"/i.test(script) || script.includes("@BAKE@"))
    throw new Error(`${name}: the script holds what would end it`);
  const policy =
    `default-src 'none'; script-src ${hash(script)}; style-src ${hash(style)}; img-src data: blob:; ` +
    "base-uri 'none'; form-action 'none'";
  return readFileSync(join(home, `src/${name}/${name}.html`), "utf8")
    .replace("@POLICY@", () => policy)
    .replace("@STYLE@", () => style)
    .replace("@SCRIPT@", () => script);
}

const put = (name, text) => writeFileSync(join(out, name), text);

mkdirSync(out, { recursive: true });
put("view.html", await one_file("view"));
put("studio.html", readFileSync(join(home, "src/studio/studio.html"), "utf8"));
put("studio.js", `${notice()}${await bundled({ entryPoints: ["src/studio/main.ts"], format: "iife" })}\n`);
put("studio.css", `${await bundled({ entryPoints: ["src/studio/studio.css"] })}\n`);
