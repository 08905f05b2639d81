// The style sheet. Text has a contrast of at least 4.5 with its background, lines at least 3 (WCAG 2.1, AA),
// in both colour schemes; tests/page measures it.
#pragma once

namespace fascicle::page {

inline constexpr const char* page_style = R"css(
:root { color-scheme: light dark;
  --paper: #ffffff; --panel: #f4f6f8; --line: #d3d9df; --ink: #1b1f24; --soft: #56606b; --accent: #0b5cad;
  --good: #146c2e; --warning: #7a4f00; --bad: #b01e14;
  --s0: #0b5cad; --s1: #b4480b; --s2: #146c2e; --s3: #7a3fb8; --s4: #7d6200; --s5: #a0256b; }
@media (prefers-color-scheme: dark) { :root {
  --paper: #14181d; --panel: #1d232a; --line: #39424c; --ink: #e6eaef; --soft: #a7b1bc; --accent: #7ab8ff;
  --good: #6fd08c; --warning: #e5b454; --bad: #ff958c;
  --s0: #7ab8ff; --s1: #ffa262; --s2: #6fd08c; --s3: #c9a2ff; --s4: #e3c657; --s5: #ff92c8; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink); font: 15px/1.5 system-ui, "Segoe UI", Roboto,
  "Helvetica Neue", Arial, "DejaVu Sans", sans-serif; overflow-wrap: anywhere; }
header, main, footer { max-width: 1160px; margin: 0 auto; padding: 0 28px; }
header { padding-top: 28px; }
h1 { font-size: 26px; line-height: 1.25; margin: 0; font-weight: 650; }
h2 { font-size: 19px; margin: 0 0 14px; font-weight: 620; }
h3 { font-size: 15px; margin: 22px 0 8px; font-weight: 620; }
p { margin: 0 0 12px; max-width: 76ch; }
a { color: var(--accent); }
:focus-visible { outline: 2px solid var(--accent); outline-offset: 2px; border-radius: 3px; }
.subtitle, .soft, figcaption, caption, footer { color: var(--soft); }
.subtitle { margin: 4px 0 0; }
.title { display: flex; align-items: center; flex-wrap: wrap; gap: 12px; }
.state { border: 1px solid currentColor; border-radius: 99px; padding: 1px 11px; font-size: 13px; font-weight: 600; }
.good { color: var(--good); } .warning { color: var(--warning); } .bad { color: var(--bad); }
nav ul { list-style: none; display: flex; flex-wrap: wrap; gap: 4px 18px; margin: 16px 0 0; padding: 10px 0;
  border-top: 1px solid var(--line); border-bottom: 1px solid var(--line); font-size: 14px; }
section { padding: 26px 0 4px; }
.facts { display: grid; grid-template-columns: repeat(auto-fit, minmax(160px, 1fr)); gap: 12px; margin: 22px 0 4px; }
.fact { background: var(--panel); border: 1px solid var(--line); border-radius: 8px; padding: 10px 14px; margin: 0; }
.fact dt { color: var(--soft); font-size: 13px; }
.fact dd { margin: 0; font-size: 20px; font-weight: 620; line-height: 1.35; }
.fact dd.note { color: var(--soft); font-size: 13px; font-weight: 400; }
.grid { display: grid; grid-template-columns: repeat(auto-fit, minmax(330px, 1fr)); gap: 18px; align-items: start; }
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(440px, 100%), 1fr)); gap: 10px 24px; }
figure { margin: 0 0 18px; } .grid figure { margin: 0; }
figcaption { font-size: 13.5px; margin: 6px 0; }
figure.plot figcaption { color: var(--ink); font-weight: 600; font-size: 14px; }
.pair { display: grid; grid-template-columns: 1fr 1fr; gap: 2px; }
img { display: block; max-width: 100%; height: auto; border-radius: 6px; }
svg { display: block; width: 100%; height: auto; }
.plot { max-width: 640px; }
.legend { list-style: none; display: flex; flex-wrap: wrap; gap: 2px 16px; padding: 0 0 0 10%; margin: 2px 0 0;
  font-size: 13px; }
.legend li { display: flex; align-items: center; gap: 6px; }
.legend svg { width: 24px; height: 8px; }
.swatches { padding: 0; margin: 0 0 18px; } .legend .swatch { width: 14px; height: 14px; border-radius: 3px; }
svg text { fill: var(--soft); font-size: 12px; }
svg .end { text-anchor: end; } svg .middle { text-anchor: middle; }
svg .grid { stroke: var(--line); stroke-width: 1; }
svg .line { fill: none; stroke-width: 2; stroke-linejoin: round; }
.s0 { stroke: var(--s0); } .s1 { stroke: var(--s1); stroke-dasharray: 7 3; } .s2 { stroke: var(--s2);
  stroke-dasharray: 2 3; } .s3 { stroke: var(--s3); stroke-dasharray: 10 3 2 3; } .s4 { stroke: var(--s4);
  stroke-dasharray: 5 2 1 2 1 2; } .s5 { stroke: var(--s5); stroke-dasharray: 14 4; }
svg .limit { stroke: var(--bad); stroke-width: 1.5; stroke-dasharray: 5 4; } svg .limit-name { fill: var(--bad); }
svg .bar { fill: var(--s0); } svg .value { fill: var(--ink); stroke: var(--paper); stroke-width: 5px;
  paint-order: stroke; }
table { border-collapse: collapse; font-size: 14px; margin: 0 0 16px; max-width: 100%; }
caption { text-align: left; padding: 0 0 6px; }
th, td { text-align: left; vertical-align: top; padding: 5px 18px 5px 0; border-bottom: 1px solid var(--line); }
thead th { color: var(--soft); font-weight: 600; }
tbody th { font-weight: 500; color: var(--soft); }
.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
.scroll { overflow-x: auto; } pre { white-space: pre-wrap; margin: 0 0 12px; }
code, .code td { font: 13px/1.5 ui-monospace, "Cascadia Mono", "DejaVu Sans Mono", monospace; }
ul.notes { list-style: none; margin: 0; padding: 0; }
ul.notes > li { border-left: 3px solid var(--warning); padding: 2px 0 2px 14px; margin: 0 0 18px; }
summary { cursor: pointer; font-weight: 600; margin: 0 0 10px; }
footer { font-size: 13px; padding-top: 18px; padding-bottom: 36px; border-top: 1px solid var(--line);
  margin-top: 26px; }
@media print { nav { display: none; } section { break-inside: avoid; } }
)css";

}  // namespace fascicle::page
