// The one door to the view library.
import { h, html as parsed } from "./vendor/htm-preact.js";
export { h, render, useState, useEffect, useLayoutEffect, useRef, useMemo, useCallback, useErrorBoundary } from "./vendor/htm-preact.js";

export const html = parsed;

/** Several parts of a view, in one element that takes no part in the layout: the order of parts that come and go stays. */
export function stack(...given) {
  const made = parsed(...given);
  return Array.isArray(made) ? h("div", { class: "parts" }, ...made) : made;
}
