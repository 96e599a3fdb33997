/** Motions for other numbers, computed by a worker; only the newest request matters. */
const PATIENCE = 1000; // ms after which a computation that nobody waits for any more is ended
const FINE = 14; // frames per swing, with fewer of which a motion is computed again
const MOST_FRAMES = 12000;

class Live {
  static limit = 20; // seconds after which a computation is given up

  constructor(text) {
    this.text = text;
    this.next = null;
    this.model = this.begin();
  }

  /** What can be computed, once the worker is there. */
  begin() {
    this.busy = null;
    return new Promise((done) => {
      try {
        this.address ??= URL.createObjectURL(new Blob([this.text], { type: "text/javascript" }));
        this.worker = new Worker(this.address);
      } catch (error) { // the page stands where workers are forbidden
        done(this.onPage());
        return;
      }
      let ready = false;
      this.worker.onerror = (event) => {
        event.preventDefault();
        if (!ready) done(this.onPage());
        else if (this.busy) this.restart(event.message);
      };
      this.worker.onmessage = ({ data }) => {
        ready = true;
        if (data.kind === "model") done(data);
        else if (data.kind === "part") this.tell(data);
        else this.finished(data);
      };
    });
  }

  /** The same program on the page itself. */
  get computing() {
    if (!window.computing) {
      document.body.append(element("script", {}, `(() => {"use strict";${this.text}\n})();`));
    }
    return window.computing;
  }

  /** Compute on the page itself. */
  onPage() {
    this.worker = {
      postMessage: (request) => setTimeout(() => this.compute(request), 30), // sliders move first
      terminate: () => {},
    };
    this.beside = false;
    return this.computing.known;
  }

  compute(request) {
    const until = performance.now() + 1000 * Live.limit;
    const why = `Not computed within ${Live.limit} s`;
    try {
      this.finished(this.computing.answer(request, () => { if (performance.now() > until) throw why; }));
    } catch (error) {
      if (error !== why) throw error;
      this.finished({ rows: [], reached: 0, status: why });
    }
  }

  /**
   * The motion for numbers at times: {time, rows, status, …}; null if it was overtaken. `part` gets
   * beginnings of it.
   */
  motion(numbers, times, tolerances, part) {
    this.forget();
    return new Promise((done) => {
      this.next = { numbers, times, tolerances, part, done };
      if (!this.busy) this.send();
      else if (this.beside && performance.now() - this.busy.since > PATIENCE) this.restart();
    });
  }

  /** Nobody waits for what comes next, nor for beginnings of what is computed. */
  forget() {
    this.next?.done(null);
    this.next = null;
    if (this.busy) this.busy.part = null;
  }

  tell({ rows, reached, parameters }) {
    const { part, times } = this.busy ?? {};
    part?.({ rows, time: times.subarray(0, reached), parameters, ideal: null });
  }

  beside = true;

  send() {
    const { numbers, times, tolerances } = this.next;
    this.busy = { ...this.next, since: performance.now() };
    this.next = null;
    this.worker.postMessage({ numbers, times, ...tolerances });
    if (!this.beside) return;
    this.watch = setTimeout(
      () => this.restart(`Not computed within ${Live.limit} s`), 1000 * Live.limit);
  }

  /** End what is computed; whoever waits for it gets nothing, or is told why. */
  restart(why = null) {
    clearTimeout(this.watch);
    this.worker.terminate();
    const { done, times } = this.busy;
    done(why && { time: times.subarray(0, 0), rows: [], status: why });
    this.begin().then(() => this.next && !this.busy && this.send());
  }

  finished({ rows, reached, ...found }) {
    clearTimeout(this.watch);
    const { times, done } = this.busy;
    this.busy = null;
    if (this.next) {
      done(null);
      this.send();
    } else {
      done({ ...found, time: times.subarray(0, reached), rows: rows.map((row) => row.subarray(0, reached)) });
    }
  }
}

/**
 * Series of a live motion with all that the page knows of them by name; `last` is the time to which
 * it will go on.
 */
function liveMotion({ model, ideal }, { time, rows, ideal: beside }, last = null) {
  const own = new Motion(time, liveSeries(model, rows), { last });
  if (!beside || beside.status) return { own, ideal: null };
  const other = new Motion(time, liveSeries(ideal, beside.rows));
  const deviations = Object.entries(CONTENT.series).flatMap(([name, known]) => {
    const [a, b] = [own, other].map((motion) => known.compared && motion.find(known.compared, ...known.place));
    return a && b ? [{ ...known, name, values: a.values.map((value, i) => value - b.values[i]), bounds: null }] : [];
  });
  return { own: new Motion(time, [...own.series, ...deviations]), ideal: other };
}

function liveSeries({ series }, rows) {
  return series.flatMap(({ name }, k) => {
    const known = CONTENT.series[name];
    return known ? [{ ...known, name, values: rows[k], bounds: null }] : [];
  });
}

/** So many times from one to another one. */
function evenTimes(start, end, count) {
  return Float64Array.from({ length: count }, (_, k) => (k === count - 1 ? end : start + ((end - start) * k) / (count - 1)));
}
