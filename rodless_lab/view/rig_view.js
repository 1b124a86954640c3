import { COLOURS, Plot, Scene } from "rodless-view";

const TERM_COLOURS = [COLOURS.orange, COLOURS.green, COLOURS.purple, COLOURS.sky, COLOURS.grey];
const DASHES = [[], [9, 5], [3, 4], [12, 4, 3, 4], [1, 3]];

// Set-points go out at most so often, in ms, while the target is dragged.
const TARGET_PERIOD = 50;

const PLOTS = (terms, first) => [
  {
    title: "Position",
    unit: "mm",
    scale: 1e3,
    span: 2,
    series: [
      { column: 7, label: "reference", colour: COLOURS.orange, dash: [9, 5] },
      { column: 1, label: "position", colour: COLOURS.blue },
    ],
  },
  {
    title: "Pressure",
    unit: "kPa absolute",
    scale: 1e-3,
    span: 20,
    series: [
      { column: 3, label: "A", colour: COLOURS.blue },
      { column: 4, label: "B", colour: COLOURS.orange, dash: [9, 5] },
      { column: 5, label: "supply", colour: COLOURS.grey, dash: [3, 4] },
    ],
  },
  {
    title: "Valve",
    unit: "V",
    scale: 1,
    span: 0.5,
    series: [{ column: 6, label: "voltage", colour: COLOURS.blue }],
  },
  ...(terms.length
    ? [
        {
          title: "Terms of the law",
          unit: "V",
          scale: 1,
          span: 0.2,
          series: terms.map((label, k) => ({
            column: first + k,
            label,
            colour: TERM_COLOURS[k % TERM_COLOURS.length],
            dash: DASHES[k % DASHES.length],
          })),
        },
      ]
    : []),
];

export default {
  template: `<div class="rig-view">
    <svg ref="scene" class="scene"></svg>
    <div class="plots"><canvas v-for="k in count" :key="k" :ref="'plot' + k"></canvas></div>
  </div>`,
  data: () => ({ count: 0 }),
  mounted() {
    this.scene = new Scene(this.$refs.scene, this.aim);
    this.rows = [];
    this.sent = 0;
    this.frames = 0;
    new ResizeObserver(() => this.draw()).observe(this.$el);
    this.$emit("ready");
  },
  methods: {
    async setup(config) {
      this.config = config;
      this.scene.setup(config);
      this.rows = [];
      this.cursor = null;
      const options = PLOTS(config.terms, config.first_term);
      this.count = options.length;
      await this.$nextTick();
      this.plots = options.map((one, k) => new Plot(this.$refs[`plot${k + 1}`][0], one));
      this.draw();
    },
    frame(news) {
      if (!this.config) return;
      this.frames += 1;
      if (this.config.mode === "bag") {
        this.cursor = news.cursor;
        this.scene.update(news.row, news.drawn);
        this.scene.ghost(news.ghost);
      } else {
        if (news.anew) this.rows = [];
        for (const row of news.rows) {
          // As the server keeps them: the newest row of those that are too close.
          const [before, last] = this.rows.slice(-2);
          if (last && last[0] - before[0] < this.config.spacing) this.rows.pop();
          this.rows.push(row);
        }
        const newest = this.rows[this.rows.length - 1];
        if (newest && news.rows.length) {
          const oldest = newest[0] - this.config.window - 1;
          const first = this.rows.findIndex((row) => row[0] >= oldest);
          if (first > 200) this.rows.splice(0, first);
          this.scene.update(newest, news.drawn);
        }
      }
      // Before the first set-point the carriage holds where it is.
      const last = this.rows[this.rows.length - 1] ?? [];
      this.scene.setTarget(news.target ?? last[7] ?? last[1] ?? null, news.locked ?? true);
      this.draw();
    },
    draw() {
      if (this.drawing || !this.plots) return;
      this.drawing = true;
      requestAnimationFrame(() => {
        this.drawing = false;
        const { mode, begin, end, tapes, window: span } = this.config;
        if (mode === "bag") {
          this.plots.forEach((plot, k) =>
            plot.draw(tapes, begin, end, k === this.plots.length - 1, this.cursor),
          );
          return;
        }
        const now = this.rows.length ? this.rows[this.rows.length - 1][0] : 0;
        const to = Math.max(now, span);
        this.plots.forEach((plot, k) =>
          plot.draw([this.rows], to - span, to, k === this.plots.length - 1),
        );
      });
    },
    aim(target, last) {
      clearTimeout(this.pending);
      const rest = last ? 0 : this.sent + TARGET_PERIOD - performance.now();
      if (rest > 0) {
        // Whoever holds the target still has it there, too.
        this.pending = setTimeout(() => this.aim(target, true), rest);
        return;
      }
      this.sent = performance.now();
      this.$emit("target", target);
    },
  },
};
