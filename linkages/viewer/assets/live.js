/** Motions for other numbers, computed by a worker; only the newest request matters. */
const PATIENCE = 600; // ms after which a computation that nobody waits for any more is ended
const FINE = 14; // frames per swing, with fewer of which a motion is computed again
const MOST_FRAMES = 12000;

class Live {
  static limit = 20; // seconds after which a computation is given up

  constructor(text) {
    this.address = URL.createObjectURL(new Blob([text], { type: "text/javascript" }));
    this.model = this.begin();
    this.next = null;
  }

  begin() {
    this.worker = new Worker(this.address);
    this.busy = null;
    return new Promise((done, failed) => {
      this.worker.onerror = (event) => {
        failed(new Error(event.message));
        if (this.busy) this.restart(event.message);
      };
      this.worker.onmessage = ({ data }) => {
        if (data.kind === "model") done(data.model); else this.finished(data);
      };
    });
  }

  /** The motion for numbers at times: {time, series, status}; null if it was overtaken. */
  motion(numbers, times, tolerances) {
    this.next?.done(null);
    return new Promise((done) => {
      this.next = { numbers, times, tolerances, done };
      if (!this.busy) this.send();
      else if (performance.now() - this.busy.since > PATIENCE) this.restart();
    });
  }

  send() {
    const { numbers, times, tolerances } = this.next;
    this.busy = { ...this.next, since: performance.now() };
    this.next = null;
    this.worker.postMessage({ numbers, times, ...tolerances });
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

  finished({ rows, reached, status }) {
    clearTimeout(this.watch);
    const { times, done } = this.busy;
    this.busy = null;
    if (this.next) {
      done(null);
      this.send();
    } else {
      done({ time: times.subarray(0, reached), rows: rows.map((row) => row.subarray(0, reached)), status });
    }
  }
}

/** Series of a live motion with all that the page knows of them by name. */
function liveMotion(model, { time, rows }) {
  return new Motion(time, model.series.flatMap((one, k) => {
    const known = CONTENT.series[one.name];
    return known ? [{ ...known, name: one.name, values: rows[k], bounds: null }] : [];
  }));
}

/** So many times from one to another one. */
function evenTimes(start, end, count) {
  return Float64Array.from({ length: count }, (_, k) => start + ((end - start) * k) / (count - 1));
}
