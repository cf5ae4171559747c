// Put at the end of a page by `verify`: tries what a reader would, and says on the console what it sees.
"use strict";
addEventListener("load", () => {
  const wrong = (what) => console.error(what);

  const slide = document.querySelector(".compare .slide");
  if (slide) {
    const pair = document.querySelector(".compare .pair");
    const before = pair.style.getPropertyValue("--at");
    slide.value = 10;
    slide.dispatchEvent(new Event("input", { bubbles: true }));
    if (pair.style.getPropertyValue("--at") === before) wrong("the slide does not move the edge");
    slide.value = 50;
    slide.dispatchEvent(new Event("input", { bubbles: true }));
  }

  const dots = [...document.querySelectorAll(".explorer .dot")];
  if (dots.length > 1) {
    const explorer = dots[0].closest(".explorer");
    const readout = explorer.querySelector(".readout");
    const silent = readout.textContent;
    const stop = explorer.querySelector(".dot[tabindex='0']");
    stop.focus();
    const first = readout.textContent;
    if (first !== stop.getAttribute("aria-label")) wrong("a point that has the focus says nothing");
    stop.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowRight", bubbles: true }));
    if (document.activeElement === stop || readout.textContent === first) wrong("arrow keys do not walk");
    const select = explorer.querySelector("select");
    if (select) {
      select.selectedIndex = 1;
      select.dispatchEvent(new Event("change"));
      const dim = explorer.querySelectorAll(".dot.dim").length;
      if (dim === 0 || dim >= explorer.querySelectorAll(".dot").length) wrong("the filter does not tell ways apart");
      select.selectedIndex = 0;
      select.dispatchEvent(new Event("change"));
      if (explorer.querySelector(".dot.dim")) wrong("the filter cannot be undone");
    }
    document.activeElement.blur();
    readout.textContent = silent;
  }

  for (const table of document.querySelectorAll("table.sortable")) {
    const rows = () => [...table.tBodies[0].rows].map((row) => row.textContent).join();
    if (table.tBodies[0].rows.length < 3) continue;
    const before = rows();
    for (const button of table.querySelectorAll("thead button")) {
      button.click();
      button.click();
    }
    if (rows() === before) wrong("a table cannot be sorted");
    break;
  }

  const broken = [...document.images].filter((picture) => picture.naturalWidth === 0).length;
  const dark = Number(matchMedia("(prefers-color-scheme: dark)").matches);
  // What a person sees is the state before all this.
  scrollTo(0, 0);
  console.info(
    `sglow-probe width=${innerWidth} needed=${document.documentElement.scrollWidth} dark=${dark} broken=${broken}`,
  );
});
