// Which estimator and which rule each of the two drives has.

function select(root, text, id, onChange) {
  const label = document.createElement("label");
  label.htmlFor = id;
  label.textContent = text;
  const list = document.createElement("select");
  list.id = id;
  list.addEventListener("change", onChange);
  root.append(label, list);
  return list;
}

function fill(list, entries, chosen) {
  list.replaceChildren(...entries.map(([value, text]) => new Option(text, value)));
  list.value = chosen;
}

// A drive with a rule, or the first one of the machine, on the estimator that it was made for, or
// else that of the default drive, the first of the layout.
export function sideOf(word, motor, layout) {
  const rule = motor.rules.find((r) => r.word === word) ?? motor.rules[0];
  return { rule, estimator: rule.estimator ?? Object.keys(layout.estimators)[0] };
}

export class Sides {
  constructor(roots, compare, layout, onChange) {
    this.layout = layout;
    this.compare = compare;
    this.onChange = onChange;
    this.lists = roots.map((root, i) => {
      const name = "AB"[i];
      return {
        root,
        estimator: select(root, "Estimator", `estimator-${name}`, () => this.changed()),
        rule: select(root, "Rule for k_s", `rule-${name}`, () => this.ruleChanged(i)),
      };
    });
    compare.addEventListener("change", () => this.changed());
  }

  // Shows the choice of a run: two sides even if only one is in use.
  show(motor, sides) {
    this.motor = motor;
    this.compare.checked = sides.length > 1;
    const second = sideOf("reference", motor, this.layout);
    this.lists.forEach((list, i) => {
      const { estimator, rule } = sides[i] ?? second;
      fill(list.estimator, Object.entries(this.layout.estimators), estimator);
      fill(list.rule, motor.rules.map((r) => [r.word, r.text]), rule.word);
    });
    this.lists[1].root.classList.toggle("unused", sides.length < 2);
    this.lists[1].estimator.disabled = this.lists[1].rule.disabled = sides.length < 2;
  }

  // A rule that was made on an estimator brings it along.
  ruleChanged(i) {
    const { estimator } = this.rule(i);
    if (estimator) this.lists[i].estimator.value = estimator;
    this.changed();
  }

  rule(i) {
    return this.motor.rules.find((rule) => rule.word === this.lists[i].rule.value);
  }

  changed() {
    this.onChange(this.chosen());
  }

  chosen() {
    const all = this.lists.map((list, i) => ({ estimator: list.estimator.value, rule: this.rule(i) }));
    return this.compare.checked ? all : all.slice(0, 1);
  }
}
