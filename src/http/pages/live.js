// Follows the job's events: moves the bar, and shows the results when the job has ended.
const box = document.getElementById("live");
const bar = box.querySelector("progress");
const text = box.querySelector("output");
const stream = new EventSource(box.dataset.events);
stream.addEventListener("progress", (event) => {
  const step = JSON.parse(event.data);
  text.textContent = `${step.stage}: ${step.done} of ${step.total}${step.message ? " – " + step.message : ""}`;
});
stream.addEventListener("status", (event) => {
  const status = JSON.parse(event.data);
  if (["successful", "failed", "dismissed"].includes(status.status)) { stream.close(); location.reload(); }
});
setInterval(async () => {
  const status = await (await fetch(box.dataset.status, { headers: { Accept: "application/json" } })).json();
  bar.value = status.progress;
  box.querySelector(".state").textContent = status.status;
}, 1000);
