// State lives in the address: every view is a link.
import { useEffect, useState } from "./html.js";

export function read() {
  const state = { view: location.pathname.replace(/^\//, "") };
  for (const [name, value] of new URLSearchParams(location.search)) state[name] = value;
  return state;
}

export function link(view, parameters = {}) {
  const made = new URLSearchParams();
  for (const [name, value] of Object.entries(parameters)) {
    if (value !== undefined && value !== null && value !== "") made.set(name, value);
  }
  const text = made.toString().replaceAll("%2F", "/").replaceAll("%2C", ",").replaceAll("%3B", ";").replaceAll("%3A", ":");
  return `/${view}${text ? `?${text}` : ""}`;
}

const listeners = new Set();
const changed = () => listeners.forEach((each) => each(read()));

export function go(view, parameters) { history.pushState(null, "", link(view, parameters)); scrollTo(0, 0); changed(); }

/** Change some parameters of the view; the step back leads over views, not over every zoom. */
export function set(parameters, push = false) {
  const { view, ...now } = read();
  const address = link(view, { ...now, ...parameters });
  if (push) history.pushState(null, "", address); else history.replaceState(null, "", address);
  changed();
}

export function useAddress() {
  const [state, put] = useState(read);
  useEffect(() => {
    const listen = (next) => put(next);
    const back = () => put(read());
    listeners.add(listen);
    addEventListener("popstate", back);
    return () => { listeners.delete(listen); removeEventListener("popstate", back); };
  }, []);
  return state;
}

/** Links of our own views change the address without loading the page anew. */
export function follow(event) {
  const found = event.target.closest && event.target.closest("a[href^='/']");
  if (!found || found.target || found.hasAttribute("download") || event.metaKey || event.ctrlKey || event.shiftKey || event.button) return;
  const url = new URL(found.href);
  if (url.pathname.startsWith("/api/") || url.pathname.startsWith("/static/")) return;
  event.preventDefault();
  history.pushState(null, "", url.pathname + url.search);
  scrollTo(0, 0);
  changed();
}
