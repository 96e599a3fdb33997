/** What linkages/viewer/content.py put into the page. */
const CONTENT = JSON.parse(document.getElementById("content").textContent);
