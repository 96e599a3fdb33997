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
  const size = Math.abs(value);
  const text = size >= 1e6 || size < 1e-4
    ? value.toExponential(digits - 1).replace("e", "·10^")
    : Number(value.toPrecision(digits)).toString();
  return text.replaceAll("-", "−");
}

/** The same with all zeros that its digits end in: columns do not jump. */
function steady(value, digits = 5) {
  if (!Number.isFinite(value) || value === 0) return figures(value, digits);
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-4) return figures(value, digits);
  return value.toPrecision(digits).replaceAll("-", "−");
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
