// What tests look at in the picture of the page: the colours of a frame, with what is drawn in it.

/** In the page: draws a frame, and keeps its picture for huesOf() and chroma(). */
export const shoot = (names) => {
  const { scene } = window.hecaton;
  const source = scene.drawPicture();
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [source.width, source.height];
  copy.getContext("2d").drawImage(source, 0, 0);
  window.shot = copy.getContext("2d").getImageData(0, 0, copy.width, copy.height);
  return { width: copy.width, height: copy.height, ...scene.cameraMatrices,
           opacities: names.map((name) => scene.opacityOf(name)),
           arms: Object.fromEntries(names.map((name) => [name, scene.drawn(name)])) };
};

/** A frame in which no arm fades: on a busy machine states come late. */
export async function shootFresh(page, names) {
  for (;;) {
    const shot = await page.evaluate(shoot, names);
    if (shot.opacities.every((opacity) => opacity === 1)) return shot;
  }
}

/** The hue of each pixel of the newest shot in degrees; −1: grey. As Base64 it leaves the page in a moment, as JSON in seconds. */
export async function huesOf(page) {
  const bytes = Buffer.from(await page.evaluate(hues), "base64");
  return new Int16Array(bytes.buffer, bytes.byteOffset, bytes.length / 2);
}
const hues = () => {
  const { data, width, height } = window.shot;
  const all = new Int16Array(width * height);
  for (let pixel = 0; pixel < all.length; ++pixel) {
    const [r, g, b] = [data[4 * pixel], data[4 * pixel + 1], data[4 * pixel + 2]];
    const most = Math.max(r, g, b);
    const chroma = most - Math.min(r, g, b);
    const sixth = most === r ? (g - b) / chroma : most === g ? (b - r) / chroma + 2 : (r - g) / chroma + 4;
    all[pixel] = chroma < 22 ? -1 : Math.round((sixth * 60 + 360) % 360);
  }
  const bytes = new Uint8Array(all.buffer);
  let text = "";
  for (let from = 0; from < bytes.length; from += 4096) text += String.fromCharCode(...bytes.subarray(from, from + 4096));
  return btoa(text);
};

/** In the page: how colourful these pixels are, on average. */
export const chroma = (pixels) => {
  const { data } = window.shot;
  const of = (pixel) => {
    const [r, g, b] = [data[4 * pixel], data[4 * pixel + 1], data[4 * pixel + 2]];
    return Math.max(r, g, b) - Math.min(r, g, b);
  };
  return pixels.reduce((sum, pixel) => sum + of(pixel), 0) / Math.max(1, pixels.length);
};

/** The hue of an arm on the screen: figures.ts chooses it in linear light. */
function hueOf(index) {
  const [h, s, l] = [(index * 0.381966 + 0.58) % 1, 0.32, 0.58];
  const part = (n) => {
    const k = (n + h * 12) % 12;
    return l - s * (1 - l) * Math.max(-1, Math.min(k - 3, 9 - k, 1));
  };
  const [r, g, b] = [part(0), part(8), part(4)].map((x) => 1.055 * x ** (1 / 2.4) - 0.055);
  const most = Math.max(r, g, b);
  const range = most - Math.min(r, g, b);
  return ((most === r ? (g - b) / range : most === g ? (b - r) / range + 2 : (r - g) / range + 4) * 60 + 360) % 360;
}
const NEAR = 40; // in any light [°]
const isNear = (hue, wanted) => hue >= 0 && Math.abs(((hue - wanted + 540) % 360) - 180) < NEAR;
export const isHue = (hue, index) => isNear(hue, hueOf(index));
/** The pixels of an arm. */
export function pixelsOf(all, index) {
  const wanted = hueOf(index);
  const pixels = [];
  all.forEach((hue, pixel) => isNear(hue, wanted) && pixels.push(pixel));
  return pixels;
}

export const LAUNCH = { args: ["--no-sandbox", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage"] };

/** A page of the browser, and the errors that it reports. */
export async function open(browser, url, viewport) {
  const page = await browser.newPage({ viewport });
  page.setDefaultTimeout(240_000); // software rendering beside other tests takes minutes
  const errors = [];
  page.on("console", (message) => message.type() === "error" && errors.push(message.text()));
  page.on("pageerror", (error) => errors.push(error.message));
  await page.goto(url);
  return { page, errors };
}
