// Helpers for the pages: they read the case and report results.
export async function readCase() {
  return await (await fetch('/case/case.json')).json();
}
export async function tell(found) {
  await fetch('/result', {method: 'POST', body: JSON.stringify(found)});
}
// Runs a page, and tells its mistakes, too.
export async function run(page) {
  try {
    await tell(await page(await readCase()));
  } catch (error) {
    await tell({error: String(error) + ' ' + (error.stack || '')});
  }
}
// The difference of two pictures where either shows something, from 0 to 1.
export function difference(a, b) {
  let squares = 0, max = 0, pixels = 0;
  for (let i = 0; i < a.length; i += 4) {
    if (a[i] + b[i] === 0) continue;
    const d = (a[i] - b[i]) / 255;
    squares += d * d;
    max = Math.max(max, Math.abs(d));
    ++pixels;
  }
  return {pixels, rms: Math.sqrt(squares / Math.max(1, pixels)), max};
}
