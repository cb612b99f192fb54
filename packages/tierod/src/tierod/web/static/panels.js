// Which signals stand in which panel: "a,b;c" is a panel of a and b over one of c.
export const parse = (text) => (text || "").split(";").filter(Boolean).map((panel) => panel.split(",").filter(Boolean).map(decodeURIComponent));
export const write = (panels) => panels.filter((each) => each.length).map((each) => each.map(encodeURIComponent).join(",")).join(";").replaceAll("%2F", "/");
export const names = (panels) => [...new Set(panels.flat())];
export const without = (panels, name) => panels.map((each) => each.filter((one) => one !== name)).filter((each) => each.length);
export function added(panels, name, into) {
  const rest = without(panels, name);
  if (into === undefined || !rest[into]) return [...rest, [name]];
  return rest.map((each, at) => (at === into ? [...each, name] : each));
}

const FIRST = ["driver_torque", "steering_wheel_angle", "vehicle_speed", "yaw_rate", "lateral_acceleration", "motor_torque"];

/** Signals that are shown where the address names none: the best known, and estimates with their spread. */
export function usual(signals, result) {
  const there = new Set(signals.map((each) => each.name));
  const estimates = result ? result.signals.filter((each) => there.has(`${each.name}_standard_deviation`)).map((each) => each.name) : [];
  const monitors = new Set(), chosen = [];
  for (const name of estimates) { const monitor = name.split("/")[0]; if (!monitors.has(monitor) && monitors.size < 2) { monitors.add(monitor); chosen.push([name]); } }
  const known = FIRST.filter((each) => there.has(each)).slice(0, 4 - Math.min(chosen.length, 1));
  const rest = known.length ? [] : signals.slice(0, 4).map((each) => each.name);
  return [...chosen, ...known.map((each) => [each]), ...rest.map((each) => [each])];
}
