import assert from "node:assert/strict";
import { test } from "node:test";
import { requestIn, timesOf, trailOf, type FilmRequest } from "../src/picture_request";

const request = (query: string) => requestIn(new URLSearchParams(query));

test("a picture of a cell that stands has no time", () => {
  const asked = request("picture=png&view=top&theme=light&layers=names,goals");
  assert.deepEqual(asked, {
    kind: "png", at: null, view: "top", dark: false,
    toggles: { goals: true, ways: false, halos: false, planning: false, binding: false, names: true, trails: false },
  });
  assert.deepEqual(trailOf(asked), []);
});

test("a film shows the recording at even steps of its own speed", () => {
  const film = request("picture=webm&at=1000&until=2000&fps=25&speed=2") as FilmRequest;
  const times = timesOf(film);
  assert.equal(times.length, 13);
  assert.equal(times[0], 1000);
  assert.equal(times[12], 1960);
  assert.equal(timesOf({ ...film, until: 1000 }).length, 1);
});

test("a trail begins two seconds earlier, but not before the recording", () => {
  const late = trailOf(request("picture=png&at=5000"));
  assert.equal(late.length, 40);
  assert.equal(late[0], 3000);
  assert.deepEqual(trailOf(request("picture=png&at=120")), [0, 50]);
});
