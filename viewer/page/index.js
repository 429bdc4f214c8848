// Builds the controls around the scene; the report's page calls angioScene.open(element, bytes).
import { Scene } from "./scene.js";

const make = (tag, attributes = {}, ...children) => {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes))
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else element.setAttribute(key, value);
  element.append(...children);
  return element;
};
const slider = (label, most, step, act) =>
  make("label", { class: "scene-slider" }, label, make("input", { type: "range", min: 0, max: most, step, value: 0, oninput: (e) => act(Number(e.target.value)) }));
const choice = (label, options, act) =>
  make("label", {}, label, make("select", { onchange: (e) => act(e.target.value) }, ...options.map(([value, text]) => make("option", { value }, text))));

const LAYERS = [["tree", "vessel tree"], ["wall", "treated wall"], ["balloon", "balloon"], ["wire", "wire"], ["lines", "centrelines"], ["cursor", "place"]];

function layerBoxes(scene) {
  const group = make("fieldset", {}, make("legend", {}, "Shown"));
  for (const [layer, name] of LAYERS) {
    if (!scene.layers[layer]) continue;
    const box = make("input", { type: "checkbox", onchange: (e) => scene.setVisible(layer, e.target.checked) });
    box.checked = true;
    group.append(make("label", {}, box, " " + name));
  }
  return group;
}

function timeControls(scene) {
  const { frames } = scene.header;
  const text = make("output", { class: "scene-time" });
  const bar = slider("Time ", frames.length - 1, 1, show);
  const input = bar.querySelector("input");
  let timer;
  const play = make("button", { type: "button", onclick: toggle }, "Play");
  function show(index) {
    const { time_s, phase, pressure_atm } = frames[index];
    text.textContent = `${time_s.toFixed(2)} s, ${phase}, ${pressure_atm.toFixed(1)} atm`;
    input.value = index;
    scene.showFrame(index);
  }
  function toggle() {
    if (timer) {
      clearInterval(timer);
      timer = undefined;
    } else {
      timer = setInterval(() => show((scene.frame + 1) % frames.length), 100);
    }
    play.textContent = timer ? "Pause" : "Play";
  }
  show(frames.findIndex((frame) => frame.is_peak));
  return make("div", { class: "scene-row" }, play, bar, text);
}

function colorControls(scene) {
  const key = make("span", { class: "scene-key", hidden: "" });
  const act = (field) => {
    scene.color(field || undefined);
    key.hidden = !field;
    if (!field) return;
    const { range, scale } = scene.fields[field];
    const bar = make("i");
    const stops = scale.map(([share, ...rgb]) => `rgb(${rgb.map((c) => Math.round(255 * c))}) ${100 * share}%`);
    bar.style.background = `linear-gradient(90deg,${stops})`;
    key.replaceChildren(range[0].toFixed(0), bar, range[1].toFixed(range[1] < 10 ? 2 : 0));
  };
  const fields = Object.entries(scene.fields).map(([name, { title }]) => [name, title]);
  return make("div", { class: "scene-row" }, choice("Wall's colour ", [["", "plain"], ...fields], act), key);
}

function cutControls(scene) {
  let on = false;
  let depth = 0;
  const box = make("input", { type: "checkbox", onchange: (e) => { on = e.target.checked; act(); } });
  const act = () => scene.cut(on ? depth : undefined);
  const bar = slider("depth ", 200, 1, (value) => { depth = value / 100 - 1; act(); });
  bar.querySelector("input").value = 100;
  return make("div", { class: "scene-row" }, make("label", {}, box, " cut open, as it is seen now"), bar);
}

function scanControls(scene) {
  let axis;
  let share = 0.5;
  const act = () => scene.slice(axis, share);
  const bar = slider("slice ", 100, 1, (value) => { share = value / 100; act(); });
  bar.querySelector("input").value = 50;
  return make("div", { class: "scene-row" },
    choice("Scan ", [["", "hidden"], ["2", "slices"], ["1", "rows"], ["0", "columns"]], (value) => { axis = value === "" ? undefined : Number(value); act(); }), bar);
}

// The diameters along the vessel; a place on the curve is the place of the sphere.
function diameterCurve(scene) {
  const { abscissa, before, peak, after, narrowest } = scene.header.diameters;
  const [width, height, edge] = [600, 120, 30];
  const last = abscissa.at(-1), first = abscissa[0];
  const top = 1.1 * Math.max(...[...before, ...peak, ...after].filter(Number.isFinite));
  const x = (s) => edge + ((width - edge - 6) * (s - first)) / (last - first || 1);
  const y = (d) => height - 18 - ((height - 24) * d) / top;
  const path = (values) => {
    let pen = "M";
    return values.map((d, i) => {
      if (d === null) { pen = "M"; return ""; }
      const command = `${pen}${x(abscissa[i]).toFixed(1)} ${y(d).toFixed(1)}`;
      pen = "L";
      return command;
    }).join("");
  };
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  svg.setAttribute("class", "chart");
  svg.setAttribute("role", "img");
  svg.setAttribute("aria-label", "diameter along the vessel, before, at peak and after");
  const levels = [0, Math.floor(top / 2) || top / 2, Math.floor(top)];
  svg.innerHTML = levels.map((d) => `<path class="grid" d="M${edge} ${y(d)}H${width - 6}"/><text class="tick end" x="${edge - 4}" y="${y(d) + 4}">${d}</text>`).join("") +
    [before, after, peak].map((values, k) => `<path class="line s${k + 1}" d="${path(values)}"/>`).join("") + `<path class="axis" id="scene-cursor"/>`;
  const text = make("output", {});
  const number = (d) => (d === null ? "–" : d.toFixed(2));
  const place = (i) => {
    svg.querySelector("#scene-cursor").setAttribute("d", `M${x(abscissa[i])} 2V${height - 18}`);
    text.textContent = `${abscissa[i].toFixed(1)} mm from the inlet: ${number(before[i])}, at peak ${number(peak[i])}, after ${number(after[i])} mm`;
    input.value = i;
    scene.placeCursor(i);
  };
  const bar = slider("Place along the vessel ", abscissa.length - 1, 1, place);
  const input = bar.querySelector("input");
  svg.addEventListener("pointermove", (event) => {
    const box = svg.getBoundingClientRect();
    const s = first + ((((event.clientX - box.left) / box.width) * width - edge) / (width - edge - 6)) * (last - first);
    place(abscissa.reduce((best, a, i) => (Math.abs(a - s) < Math.abs(abscissa[best] - s) ? i : best), 0));
  });
  place(narrowest);
  const key = make("p", { class: "sub" }, "Diameter [mm]");
  for (const [color, name] of [["--c1", "before"], ["--c3", "at peak"], ["--c2", "after"]])
    key.append(make("span", { class: "key", style: `background:var(${color})` }), name);
  return make("div", {}, key, svg, make("div", { class: "scene-row" }, bar, text));
}

export function open(element, bytes) {
  const picture = make("div", { class: "scene-view", role: "img", "aria-label": "vessel tree, wall, balloon and wire in three dimensions" });
  element.replaceChildren(picture);
  const scene = new Scene(picture, bytes);
  element.append(make("div", { class: "scene-row" },
    make("button", { type: "button", onclick: () => scene.lookAt("lesion") }, "Lesion"),
    make("button", { type: "button", onclick: () => scene.lookAt("tree") }, "Whole tree"), layerBoxes(scene)));
  if (scene.wall) element.append(timeControls(scene), colorControls(scene));
  element.append(cutControls(scene));
  if (scene.scan) element.append(scanControls(scene));
  if (scene.header.diameters) element.append(diameterCurve(scene));
  element.dataset.state = "open";
  return scene;
}
