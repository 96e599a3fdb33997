/** What linkages/viewer/recorded.py has deflated. */
function inflated(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate")));
}

/** Starts the program of the page. What it returns is what tests ask, and whoever opens the console. */
async function begun() {
  const made = document.createElement("script");
  made.textContent = await inflated(document.getElementById("program").textContent).text();
  document.body.append(made);
  return start();
}

/** Numbers of the page from their text, as linkages/viewer/recorded.py writes it. */
async function unpacked(text) {
  const planes = new Uint8Array(await inflated(text).arrayBuffer());
  const count = planes.length / 4;
  const bits = new Uint32Array(count);
  let sum = 0;
  for (let i = 0; i < count; i++) {
    const step = planes[i] | (planes[count + i] << 8) | (planes[2 * count + i] << 16)
      | (planes[3 * count + i] << 24);
    sum = (sum + step) >>> 0;
    bits[i] = sum;
  }
  return new Float32Array(bits.buffer);
}

/** The array at a place among all numbers. */
function arrayAt(numbers, [start, count]) {
  return numbers.subarray(start, start + count);
}

/** An array of 64-bit floats that is there as two of 32 bits. */
function exactAt(numbers, [rounded, rest]) {
  const high = arrayAt(numbers, rounded), low = arrayAt(numbers, rest);
  return Float64Array.from(high, (value, i) => value + low[i]);
}

window.viewer = begun();
