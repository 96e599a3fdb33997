/** How values are written: CONTENT.scales has for each unit [from which size, factor, text]. */
const DEGREES = { factor: 180 / Math.PI, text: "°" };

function scaleFor(peak, unit) {
  if (unit === "rad") return DEGREES;
  const steps = CONTENT.scales[unit] ?? [[0, 1, unit === "1" ? "" : unit]];
  let found = steps[0];
  for (const step of steps) if (peak >= step[0]) found = step;
  return { factor: found[1], text: found[2] };
}

/** A number with so many significant digits, and a minus sign that is one. */
function figures(value, digits = 5) {
  if (!Number.isFinite(value)) return Number.isNaN(value) ? "–" : value > 0 ? "∞" : "−∞";
  if (value === 0) return "0";
  return written(value, digits, () => Number(value.toPrecision(digits)).toString());
}

/** The same with all zeros that its digits end in: columns do not jump. */
function steady(value, digits = 5) {
  if (!Number.isFinite(value) || value === 0) return figures(value, digits);
  const long = Math.abs(value) >= 10 ** digits;
  return written(value, digits, () => (long ? String(Math.round(value)) : value.toPrecision(digits)));
}

function written(value, digits, plain) {
  const size = Math.abs(value);
  if (size >= 1e9 || size < 1e-4) {
    const [front, power] = value.toExponential(digits - 1).split("e");
    const raised = Array.from(String(Number(power)), (sign) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(sign)]);
    return `${front}·10${raised.join("")}`.replaceAll("-", "−");
  }
  return plain().replaceAll("-", "−");
}

/** An SI value with its unit. */
function quantity(value, unit, digits = 4) {
  const scale = scaleFor(Math.abs(value), unit);
  const gap = scale.text === "°" ? "" : "\u202f";
  return figures(value * scale.factor, digits) + (scale.text ? gap + scale.text : "");
}

/** The largest magnitude of finite values. */
function largest(values) {
  let found = 0;
  for (const value of values) if (Number.isFinite(value)) found = Math.max(found, Math.abs(value));
  return found;
}

/** Whose a series is, without what it is: "crank" of the driving torque of crank. */
function ownerOf({ words, label }) {
  return words.startsWith(`${label} of `) ? words.slice(label.length + 4) : "";
}
