// What is wrong with a page for those who read it with a keyboard, a screen reader or a phone, as a list of
// sentences. Contrast as WCAG 2.1, 1.4.3: 4.5 for text.
const pageFaults = () => {
  const faults = new Set();
  const start = (element) => element.outerHTML.slice(0, 90);

  for (const control of document.querySelectorAll("button,input,select,textarea,a[href]")) {
    const name = control.getAttribute("aria-label") || control.labels?.[0]?.textContent || control.textContent;
    if (!name.trim()) faults.add("no name: " + start(control));
    if (control.tabIndex !== 0) faults.add("not in the order of keys: " + start(control));
    if (control.disabled || !control.getClientRects().length) continue;
    control.focus({ focusVisible: true });
    if (getComputedStyle(control).outlineStyle === "none") faults.add("focus is not seen: " + start(control));
  }
  for (const image of document.querySelectorAll("img")) if (!image.alt) faults.add("no alt: " + start(image));
  for (const drawing of document.querySelectorAll("svg"))
    if (drawing.getAttribute("role") !== "img" || !drawing.getAttribute("aria-label")) faults.add("no name: " + start(drawing));

  const ids = [...document.querySelectorAll("[id]")].map((element) => element.id);
  for (const id of ids) if (ids.indexOf(id) !== ids.lastIndexOf(id)) faults.add("twice: id " + id);

  let level = 0;
  for (const heading of document.querySelectorAll("h1,h2,h3,h4")) {
    const own = Number(heading.tagName[1]);
    if (own > level + 1) faults.add("a level is left out before: " + heading.textContent);
    level = own;
  }
  if (document.querySelectorAll("h1").length !== 1) faults.add("not one h1");

  const color = (text) => text.match(/[\d.]+/g).map(Number);
  const over = ([r, g, b, a = 1], ground) => [r, g, b].map((value, i) => value * a + ground[i] * (1 - a));
  const luminance = (rgb) => {
    const [r, g, b] = rgb.map((value) => (value <= 10 ? value / 3294.6 : ((value / 255 + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const paper = matchMedia("(prefers-color-scheme:dark)").matches ? [0, 0, 0] : [255, 255, 255];
  const ground = (element) => over(color(getComputedStyle(element).backgroundColor), element.parentElement ? ground(element.parentElement) : paper);
  const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (texts.nextNode()) {
    const element = texts.currentNode.parentElement;
    if (!texts.currentNode.textContent.trim() || !element.getClientRects().length) continue;
    const style = getComputedStyle(element);
    const drawing = element.closest("svg");
    // A label on a picture has an edge of its own.
    const edge = drawing && style.strokeWidth !== "1px" && style.stroke !== "none" ? color(style.stroke) : undefined;
    const behind = edge ?? ground(drawing ? drawing.parentElement : element);
    const front = over(color(drawing ? style.fill : style.color), behind);
    const [dark, light] = [luminance(front), luminance(behind)].sort((a, b) => a - b);
    const contrast = (light + 0.05) / (dark + 0.05);
    if (!(contrast >= 4.5)) faults.add(`contrast ${contrast.toFixed(2)}: ${texts.currentNode.textContent.slice(0, 30)}`);
  }

  if (document.documentElement.scrollWidth > innerWidth) faults.add("scrolls sideways: " + document.documentElement.scrollWidth);
  for (const chart of document.querySelectorAll("svg.chart")) {
    const frame = chart.getBoundingClientRect();
    const labels = [...chart.querySelectorAll("text")].map((text) => ({ text, box: text.getBoundingClientRect() })).filter(({ box }) => box.width);
    for (const { text, box } of labels) {
      const name = `${chart.getAttribute("aria-label")}: ${text.textContent}`;
      if (box.right > frame.right + 1 || box.left < frame.left - 1) faults.add("cut: " + name);
      if (!text.hasAttribute("transform") && box.height < 10) faults.add("small: " + name);
      for (const other of labels) {
        const width = Math.min(box.right, other.box.right) - Math.max(box.left, other.box.left);
        const height = Math.min(box.bottom, other.box.bottom) - Math.max(box.top, other.box.top);
        if (other.text !== text && width > 1 && height > 0.3 * box.height) faults.add(`on ${other.text.textContent}: ${name}`);
      }
    }
  }
  return [...faults];
};
