// What the reading of a recording found: said once, above its charts and verdicts.
import { html } from "./html.js";
import { link } from "./address.js";
import { sentence } from "./parts.js";

const UNIT = /^(\w+) \(.*\) has no unit in the file and was taken as ([^\s:,]+)(?:, but reaches \S+ and looks like ([^\s:]+))?:/;

/** {units: [{name, taken, like}], others} of the warnings: those on units name one signal each, and become one sentence. */
export function sorted(warnings) {
  const units = [], others = [];
  for (const each of warnings) {
    const found = UNIT.exec(each);
    if (found) units.push({ name: found[1].replaceAll("_", " "), taken: found[2].replaceAll("**2", "²").replaceAll("*", "·"), like: found[3] });
    else others.push(each);
  }
  return { units, others };
}

/** Warnings that several verdicts share, each with the monitors that it holds for; those of the reading are not among them. */
export function shared(monitors, warnings) {
  const found = new Map(), known = new Set(warnings);
  for (const [name, each] of Object.entries(monitors)) for (const f of each.findings) for (const w of f.warnings) if (!known.has(w)) found.set(w, (found.get(w) || new Set()).add(name));
  return new Map([...found].filter(([, names]) => names.size > 1));
}

export function Remarks({ warnings, file }) {
  if (!warnings.length) return null;
  const { units, others } = sorted(warnings), doubtful = units.filter((each) => each.like), rest = units.filter((each) => !each.like);
  return html`<div class="note">
    ${doubtful.length > 0 && html`<p><b>Probably in other units:</b> ${doubtful.map((each) => `${each.name} was taken as ${each.taken} and looks like ${each.like}`).join("; ")}. Charts and verdicts are wrong until that is corrected.</p>`}
    ${rest.length > 0 && html`<p>No unit in the file: ${rest.map((each) => `${each.name} was taken as ${each.taken}`).join(", ")}.</p>`}
    ${others.map((each) => html`<p>${sentence(each)}</p>`)}
    ${units.length > 0 && html`<p><a href=${link("new", { file })}>${doubtful.length ? "Correct the units" : "Confirm the units"}</a> in the channel map.</p>`}</div>`;
}
