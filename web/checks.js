// Checks of accessibility that run in the page.

const visible = (e) =>
  e.checkVisibility({ opacityProperty: true, visibilityProperty: true }) && e.getClientRects().length > 0;

// Controls and pictures without a name; a picture inside a link or a button goes by the name of that.
function unnamed() {
  const controls = document.querySelectorAll("button, input, select, [role=slider], canvas, svg");
  const name = (e) =>
    e.getAttribute("aria-label") || e.title || [...(e.labels ?? [])].map((l) => l.textContent).join("") ||
    (e.tagName === "BUTTON" ? e.textContent : "");
  const inside = (e) => e.parentElement.closest("a, button, label");
  return [...controls].filter((e) => visible(e) && !inside(e) && !String(name(e)).trim()).map((e) => e.outerHTML);
}

function rgb(text) {
  return (text.match(/[\d.]+/g) ?? [0, 0, 0, 0]).map(Number);
}

function luminance([r, g, b]) {
  const linear = [r, g, b].map((x) => x / 255).map((x) => (x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4));
  return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
}

// A colour on top of an opaque one.
function over([r, g, b, alpha = 1], below) {
  return [r, g, b].map((x, j) => alpha * x + (1 - alpha) * below[j]);
}

function background(e) {
  if (!e) return [255, 255, 255];
  const colour = rgb(getComputedStyle(e).backgroundColor);
  return (colour[3] ?? 1) === 1 ? colour.slice(0, 3) : over(colour, background(e.parentElement));
}

// Text whose contrast with what is behind it is below `least`.
function faint(least) {
  const out = [];
  for (const e of document.querySelectorAll("body *")) {
    const own = [...e.childNodes].some((n) => n.nodeType === Node.TEXT_NODE && n.textContent.trim());
    if (!own || !visible(e) || e.disabled || e.closest("script, style")) continue;
    const style = getComputedStyle(e);
    const svg = e instanceof SVGElement;
    const behind = background(e);
    const [a, b] = [over(rgb(svg ? style.fill : style.color), behind), behind].map(luminance);
    const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (ratio < least) out.push(`${ratio.toFixed(2)}: ${e.outerHTML.slice(0, 80)}`);
  }
  return out;
}

// Plots that lack the colour of a drive, which the style names.
function uncoloured() {
  const style = getComputedStyle(document.documentElement);
  const wanted = ["--a", "--b"].map((name) => {
    const hex = style.getPropertyValue(name).trim();
    return [1, 3, 5].map((j) => parseInt(hex.slice(j, j + 2), 16));
  });
  const lacks = (canvas) => {
    const copy = new OffscreenCanvas(canvas.width, canvas.height);
    const g = copy.getContext("2d", { willReadFrequently: true });
    g.drawImage(canvas, 0, 0);
    const { data } = g.getImageData(0, 0, canvas.width, canvas.height);
    return wanted.some(([r, g, b]) => {
      for (let i = 0; i < data.length; i += 4) {
        if (data[i] === r && data[i + 1] === g && data[i + 2] === b && data[i + 3] > 200) return false;
      }
      return true;
    });
  };
  return [...document.querySelectorAll("canvas")].filter((c) => visible(c) && lacks(c))
    .map((c) => c.getAttribute("aria-label"));
}
