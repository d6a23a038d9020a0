'use strict';
// Looks at the page in each frame and writes what it finds into #found, as JSON.
const answers = [];
const look = frame => {
  const found = { errors: [], requests: [], figures: [], moved: [], switched: null, time: null, tip: null, unnamed: 0, wide: 0 };
  const page = frame.contentDocument, view = frame.contentWindow;
  view.addEventListener('error', event => found.errors.push(String(event.message)));
  page.addEventListener('securitypolicyviolation', event => found.errors.push('blocked: ' + event.blockedURI));
  try {
    const visible = element => element.getClientRects().length > 0;
    const state = () => [...page.querySelectorAll('.shape, .now')].filter(visible).map(element => {
      const box = element.getBoundingClientRect();
      return [box.left, box.top, box.width, box.height].map(x => x.toFixed(1)).join(' ');
    });
    found.wide = page.documentElement.scrollWidth;
    for (const figure of page.querySelectorAll('svg.figure')) {
      if (!visible(figure)) continue;
      const box = figure.getBoundingClientRect();
      found.figures.push({
        name: figure.getAttribute('aria-label'), left: box.left, right: box.right, height: box.height,
        marks: figure.querySelectorAll('polyline, circle, line, rect').length,
      });
    }
    for (const control of page.querySelectorAll('input, button, select')) {
      const label = control.getAttribute('aria-label') || control.textContent || (control.labels && control.labels.length && control.labels[0].textContent);
      if (!label || control.tabIndex < 0) found.unnamed += 1;
    }
    // without its script nothing of this happens
    const slider = page.getElementById('time');
    if (slider) {
      if (slider.closest('.controls').hidden) found.errors.push('the slider is hidden');
      for (const part of [0.5, 1]) {
        const before = state();
        slider.value = Math.round(part * slider.max);
        slider.dispatchEvent(new view.Event('input', { bubbles: true }));
        const after = state();
        // what moves is the mechanism or the path, and every cursor
        found.moved.push(before.length > 1 && before[0] !== after[0] || before.filter((place, index) => place !== after[index]).length > before.length / 2);
      }
      found.time = slider.getAttribute('aria-valuetext');
    }
    for (const choice of page.querySelectorAll('fieldset.switch')) if (choice.hidden) found.errors.push('the switch is hidden');
    const choices = [...page.querySelectorAll('fieldset.switch input')];
    if (choices.length > 1) {
      const shown = () => [...page.querySelectorAll('figure[data-switch]')].filter(visible).map(figure => figure.dataset.choice).join();
      const before = shown();
      choices[1].click();
      found.switched = shown() === choices[1].value && before === choices[0].value;
    }
    const figure = [...page.querySelectorAll('figure')].find(figure => visible(figure) && (figure.dataset.column || figure.dataset.points));
    const svg = figure.querySelector('svg');
    const mark = figure.dataset.points ? svg.querySelectorAll('circle')[2] : svg.querySelector('g.axes polyline:last-of-type') || svg;
    const box = (figure.dataset.points ? mark : svg).getBoundingClientRect();
    svg.dispatchEvent(new view.PointerEvent('pointermove', {
      bubbles: true, clientX: box.left + box.width / 2, clientY: box.top + box.height / 2,
    }));
    const tip = figure.querySelector('.tip');
    found.tip = tip && tip.textContent;
    found.requests = view.performance.getEntriesByType('resource').map(entry => entry.name);
  } catch (error) {
    found.errors.push(String(error && error.stack || error));
  }
  return found;
};
window.addEventListener('load', () => {
  for (const frame of document.querySelectorAll('iframe')) answers.push(look(frame));
  document.getElementById('found').textContent = JSON.stringify(answers);
});
