// The page: navigation, theme, and the view that the address names.
import { html, stack, render, useEffect, useErrorBoundary, useState } from "./html.js";
import { SILENT, site as served } from "./api.js";
import { follow, useAddress } from "./address.js";
import { Loading, Trouble, useFetched } from "./parts.js";
import { Files } from "./files.js";
import { Recording } from "./recording.js";

/** A view that the page fetches once it is asked for. */
function later(fetched, name) {
  let View;
  return function Later(properties) {
    const [error, put] = useState(null), [, again] = useState(0);
    useEffect(() => { if (!View) fetched().then((found) => { View = found[name]; again(1); }, put); }, []);
    // Browsers keep a module that could not be fetched as failed until the page is loaded anew.
    if (error) return html`<${Trouble} error=${{ message: SILENT }} again=${() => location.reload()} />`;
    return View ? html`<${View} ...${properties} />` : html`<${Loading} />`;
  };
}

const jobs = () => import("./jobs.js");

const VIEWS = { "": [Files, "Recordings"], recording: [Recording, ""],
  new: [later(() => import("./new.js"), "New"), "New recording"],
  fleet: [later(() => import("./fleet.js"), "Fleet"), "Fleet"], vehicle: [later(() => import("./vehicle.js"), "Vehicle"), "Vehicle"],
  scenario: [later(() => import("./scenario.js"), "Scenario"), "Scenario"], live: [later(() => import("./live.js"), "Live"), "Live"],
  jobs: [later(jobs, "JobList"), "Work"], interface: [later(jobs, "Interface"), ""] };

const Nowhere = () => stack`<h1>There is nothing at this address</h1><p>“${location.pathname.slice(0, 200)}” is no view of this page. Begin with the <a href="/">recordings</a>, or choose a view above.</p>`;

function Theme() {
  const dark = () => (document.documentElement.dataset.theme || (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light")) === "dark";
  const [now, put] = useState(dark());
  useEffect(() => {
    const system = matchMedia("(prefers-color-scheme: dark)"), turned = () => { put(dark()); dispatchEvent(new Event("tierod-theme")); };
    system.addEventListener("change", turned);
    return () => system.removeEventListener("change", turned);
  }, []);
  const turn = () => {
    const next = dark() ? "light" : "dark";
    document.documentElement.dataset.theme = next;
    try { localStorage.setItem("tierod-theme", next); } catch (_) { /* not kept then */ }
    put(next === "dark");
    dispatchEvent(new Event("tierod-theme"));
  };
  return stack`<button onClick=${turn} aria-pressed=${now} title="Light or dark">${now ? "Dark" : "Light"}</button>`;
}

function Shell() {
  const address = useAddress();
  const site = useFetched(served, []);
  const [View, title] = VIEWS[address.view] || [Nowhere, "Nothing here"];
  useEffect(() => { document.title = `${address.file ? `${address.file.split("/").pop()} · ` : title ? `${title} · ` : ""}tierod`; }, [address.view, address.file]);
  const current = address.view === "recording" ? "" : address.view;
  return stack`<a class="skip" href="#content">To the content</a>
    <header class="top"><a class="brand" href="/">tierod</a><nav class="views" aria-label="Views">${Object.entries(VIEWS).filter(([view, [, name]]) => name && !(view === "scenario" && site.data && !site.data.scenarios)).map(([view, [, name]]) => html`<a key=${view} href=${`/${view}`} aria-current=${view === current ? "page" : undefined}>${name}</a>`)}</nav>
      <a class="small" href="/interface">Interface</a><${Theme} /></header>
    <main id="content" tabindex="-1">${site.error ? html`<${Trouble} error=${site.error} again=${site.again} />` : html`<${Bounded} key=${address.view}><${View} address=${address} site=${site.data} /><//>`}</main>`;
}

function Bounded({ children }) {
  const [error, again] = useErrorBoundary((found) => console.error(found));
  return error ? html`<${Trouble} error=${{ message: `the page has a defect (${error.message}); reload it, and report it if it comes again` }} again=${again} />` : children;
}

document.addEventListener("click", follow);
const place = document.getElementById("app");
place.textContent = "";
render(html`<${Shell} />`, place);
