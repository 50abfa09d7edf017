// SPDX-License-Identifier: MIT
"use strict";

// Without script the page is complete; with it the table sorts and the settings can be copied.

for (const header of document.querySelectorAll("th[data-column]")) {
    header.querySelector("button").addEventListener("click", () => sort_by(header));
}

function sort_by(header) {
    const direction = header.getAttribute("aria-sort") === "ascending" ? -1 : 1;
    for (const other of header.parentElement.children) {
        other.removeAttribute("aria-sort");
    }
    header.setAttribute("aria-sort", direction === 1 ? "ascending" : "descending");
    const column = header.cellIndex;
    const key = (row) => row.cells[column].dataset.value;
    const is_number = header.dataset.column === "number";
    const compare = (a, b) => is_number ? Number(key(a)) - Number(key(b)) : key(a).localeCompare(key(b));
    const body = header.closest("table").tBodies[0];
    const rows = Array.from(body.rows);
    rows.sort((a, b) => direction * compare(a, b));
    body.append(...rows);
}

for (const button of document.querySelectorAll("button.copy")) {
    button.addEventListener("click", () => copy_from(button));
}

async function copy_from(button) {
    const source = document.getElementById(button.dataset.source);
    try {
        await navigator.clipboard.writeText(source.textContent);
        button.textContent = "Copied";
    } catch {
        // Browsers refuse the clipboard to pages from files: then at least mark the text.
        getSelection().selectAllChildren(source);
        button.textContent = "Marked: press Ctrl+C";
    }
}
