// The parts of the report page that are always the same: style, script and mark. They are part of
// every report, so they name nothing outside it.
#pragma once

#include <string_view>

namespace tread {

inline constexpr std::string_view kReportStyle = R"css(
:root{--bg:#f4f6f8;--card:#fff;--ink:#171b21;--soft:#5b6675;--line:#dde2e8;--accent:#0b7a75;
--accent-soft:#d9efed;--warn:#8a5a00;--warn-soft:#fff1d2;--code:#eceff3;color-scheme:light dark}
@media (prefers-color-scheme:dark){:root{--bg:#0e1116;--card:#171b22;--ink:#e8ebf0;--soft:#98a3b3;
--line:#2a313b;--accent:#45c9bf;--accent-soft:#12312f;--warn:#f3c969;--warn-soft:#362a10;
--code:#0a0d11}}
*{box-sizing:border-box}
html{scroll-behavior:smooth;scroll-padding-top:4rem;-webkit-text-size-adjust:100%}
body{margin:0;background:var(--bg);color:var(--ink);
font:16px/1.55 system-ui,-apple-system,"Segoe UI",Roboto,"Noto Sans","DejaVu Sans",sans-serif}
header,main,footer{max-width:82rem;margin:0 auto;padding:0 clamp(1rem,3vw,2.5rem)}
header{padding-top:2.6rem;padding-bottom:.4rem}
.mark{display:flex;align-items:center;gap:.6rem;color:var(--accent);font-weight:650;
letter-spacing:.02em;margin-bottom:1.1rem}
.mark svg{width:1.9rem;height:1.9rem}
h1{font-size:clamp(1.7rem,3.6vw,2.6rem);line-height:1.15;letter-spacing:-.02em;margin:0 0 .35rem}
.subtitle{font-size:1.12rem;color:var(--soft);margin:0;max-width:60rem}
.command{margin:1.1rem 0 0;padding:.7rem 1rem;background:var(--code);border:1px solid var(--line);
border-radius:.6rem;font:.88rem/1.5 ui-monospace,"Cascadia Mono",Menlo,Consolas,
"DejaVu Sans Mono",monospace;white-space:pre-wrap;overflow-wrap:anywhere}
.command::before{content:"$ ";color:var(--accent);font-weight:700}
nav{position:sticky;top:0;z-index:3;background:var(--bg);border-bottom:1px solid var(--line);
margin-top:1.4rem}
nav div{max-width:82rem;margin:0 auto;padding:.55rem clamp(1rem,3vw,2.5rem);display:flex;
gap:.35rem;overflow-x:auto;scrollbar-width:none}
nav a{color:var(--soft);text-decoration:none;font-size:.92rem;padding:.28rem .75rem;
border-radius:2rem;white-space:nowrap}
nav a:hover,nav a:focus-visible{background:var(--accent-soft);color:var(--accent)}
section{margin:2.4rem 0 0}
h2{font-size:1.4rem;letter-spacing:-.01em;margin:0 0 .3rem}
h3{font-size:1.02rem;margin:0}
.lead{color:var(--soft);margin:0 0 1rem;max-width:60rem}
.note{border-left:4px solid var(--accent);background:var(--accent-soft);padding:.7rem 1rem;
border-radius:.4rem;margin:1rem 0;max-width:60rem}
.note.warning{border-color:var(--warn);background:var(--warn-soft)}
.tiles{display:grid;grid-template-columns:repeat(auto-fit,minmax(10rem,1fr));gap:1rem;
margin:1.4rem 0}
.tile,figure,.card{background:var(--card);border:1px solid var(--line);border-radius:.9rem;
box-shadow:0 1px 2px rgba(10,16,24,.05)}
.tile{padding:.9rem 1.1rem}
.tile b{display:block;font-size:1.9rem;line-height:1.2;letter-spacing:-.02em;font-weight:680;
font-variant-numeric:tabular-nums}
.tile b small{font-size:.95rem;font-weight:500;color:var(--soft);margin-left:.25rem;
letter-spacing:0}
.tile span{color:var(--soft);font-size:.9rem}
.figures{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,26rem),1fr));
gap:1.2rem;margin:1.1rem 0;align-items:start}
figure{margin:0;padding:1rem;break-inside:avoid}
figure.wide{grid-column:1/-1}
.frame{position:relative;margin:.7rem auto .8rem;width:min(100%,calc(var(--ratio)*36rem));
aspect-ratio:var(--ratio);border-radius:.45rem;overflow:hidden}
.wide .frame{width:min(100%,calc(var(--ratio)*52rem))}
.frame img{display:block;width:100%;height:100%}
.frame[data-values]{cursor:crosshair}
.cross{position:absolute;width:22px;height:22px;margin:-11px 0 0 -11px;pointer-events:none;
border:2px solid #fff;border-radius:50%;box-shadow:0 0 0 1.5px #10131a,inset 0 0 0 1.5px #10131a}
.legend{font-size:.84rem;color:var(--soft);margin:0 0 .6rem}
.bar{position:relative;height:.75rem;border-radius:.25rem;margin:.15rem 0 .2rem}
.tick{position:absolute;top:-3px;bottom:-3px;width:3px;margin-left:-1.5px;background:#fff;
border-radius:2px;box-shadow:0 0 0 1.5px #10131a}
.ends{display:flex;justify-content:space-between;font-variant-numeric:tabular-nums}
.name{color:var(--ink)}
.marks{display:flex;flex-wrap:wrap;gap:.15rem 1rem;margin-top:.3rem}
.marks i{display:inline-block;width:.8rem;height:.8rem;border-radius:.2rem;margin-right:.4rem;
border:1px solid rgba(16,19,26,.55);vertical-align:-.08rem}
.readout{display:block;min-height:1.4em;font-size:.88rem;font-variant-numeric:tabular-nums;
color:var(--accent);font-weight:600}
figcaption{font-size:.93rem;color:var(--soft)}
.card{padding:1rem 1.2rem;margin:1.1rem 0;overflow-x:auto;scrollbar-width:thin;break-inside:avoid}
table{border-collapse:collapse;width:100%;font-size:.93rem;margin-top:.4rem}
th,td{text-align:left;padding:.42rem .9rem .42rem 0;border-bottom:1px solid var(--line);
vertical-align:top}
th{color:var(--soft);font-weight:600;font-size:.84rem}
tr:last-child td{border-bottom:0}
.num{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
.share{width:30%;min-width:6rem}
.share div{height:.7rem;background:var(--accent);border-radius:.2rem;min-width:2px;
margin-top:.35rem}
.badge{display:inline-block;background:var(--warn-soft);color:var(--warn);border:1px solid;
border-radius:1rem;padding:0 .6rem;font-size:.78rem;font-weight:650;line-height:1.5;
white-space:nowrap}
.remark{color:var(--soft)}
footer{color:var(--soft);font-size:.85rem;padding-top:2.5rem;padding-bottom:3rem}
@media (max-width:40rem){.share{display:none}}
@media print{nav{display:none}body{background:#fff}}
)css";

// Shows place and value under the pointer in every picture of the same frame.
inline constexpr std::string_view kReportScript = R"js(
"use strict";
(() => {
  const frames = [...document.querySelectorAll(".frame[data-values]")].map((element) => {
    const d = element.dataset;
    const bytes = Uint8Array.from(atob(d.values), (c) => c.charCodeAt(0));
    const figure = element.closest("figure");
    const numbers = (text) => text.split(" ").map(Number);
    const [left, top, right, bottom] = numbers(d.corners);
    const [width, height, step, columns] = numbers(d.size);
    const [low, high] = numbers(d.range);
    return {element, name: d.frame, axis: d.axis, unit: d.unit, left, top, right, bottom, width,
            height, step, columns, low, high, data: new DataView(bytes.buffer),
            scale: d.scale ? numbers(d.scale) : null, cross: element.querySelector(".cross"),
            readout: figure.querySelector(".readout"), tick: figure.querySelector(".tick")};
  });
  const digits = (v) => {
    const size = Math.abs(v);
    return v.toFixed(size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : 3);
  };
  const hide = (f) => {
    f.cross.hidden = true;
    if (f.tick) f.tick.hidden = true;
    f.readout.textContent = "";
  };
  const show = (f, x, y) => {
    const u = (x - f.left) / (f.right - f.left), v = (y - f.top) / (f.bottom - f.top);
    if (!(u >= 0 && u < 1 && v >= 0 && v < 1)) return hide(f);
    const i = Math.floor(u * f.width / f.step), j = Math.floor(v * f.height / f.step);
    const code = f.data.getUint16(2 * (j * f.columns + i), true);
    const value = f.low + (code - 1) / 65534 * (f.high - f.low);
    const place = f.axis === "px" ? [Math.floor(x + 0.5), Math.floor(y + 0.5)]
                                  : [x.toFixed(2), y.toFixed(2)];
    const unit = f.unit ? " " + f.unit : "";
    f.readout.textContent = `x ${place[0]}  y ${place[1]} ${f.axis}  →  ` +
        (code === 0 ? "unknown" : digits(value) + unit);
    f.cross.hidden = false;
    f.cross.style.left = 100 * u + "%";
    f.cross.style.top = 100 * v + "%";
    if (!f.tick) return;
    f.tick.hidden = code === 0;
    const share = (value - f.scale[0]) / (f.scale[1] - f.scale[0]);
    f.tick.style.left = 100 * Math.min(1, Math.max(0, share)) + "%";
  };
  for (const f of frames) {
    const same = frames.filter((other) => other.name === f.name);
    f.element.addEventListener("pointermove", (event) => {
      const box = f.element.getBoundingClientRect();
      const x = f.left + (event.clientX - box.left) / box.width * (f.right - f.left);
      const y = f.top + (event.clientY - box.top) / box.height * (f.bottom - f.top);
      for (const other of same) show(other, x, y);
    });
    f.element.addEventListener("pointerleave", () => same.forEach(hide));
  }
  for (const picture of document.querySelectorAll(".frame")) {
    picture.addEventListener("dblclick", () => {
      picture.closest("figure").classList.toggle("wide");
    });
  }
})();
)js";

// Three contour lines of a hill.
inline constexpr std::string_view kReportMark =
    "<svg viewBox=\"0 0 32 32\" fill=\"none\" stroke=\"currentColor\" stroke-width=\"2.2\" "
    "stroke-linecap=\"round\" aria-hidden=\"true\">"
    "<path d=\"M3 24c5-1 6-15 12-16s6 9 14 8\"></path>"
    "<path d=\"M7 27c5-1 5-12 9-12.500s5 8 13 7\"></path>"
    "<path d=\"M13 28.500c3-1 2-6.500 4.500-6.500s4 5 11.500 5\"></path></svg>";

}  // namespace tread
