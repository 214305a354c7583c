"""Keys, the palette and the help sheet ask for actions, and leave alone who types."""

from __future__ import annotations

from playwright.sync_api import expect

from app.chromium import ROOM, Opener, until
from splinescope.actions import ACTIONS, PageRequest
from splinescope.browser.page import Page

PLAYWRIGHT_NAMES = {" ": "Space"}


def test_every_key_asks_for_its_action_and_moves_nothing(page: Page, open_window: Opener) -> None:
    asked: list[str] = []
    page.on_action(asked.append)
    page.fit(ROOM)
    window = open_window(page.url)
    before = window.settled()
    table = [(action, key) for action in ACTIONS.values() for key in action.keys]
    told = [(action, key) for action, key in table if action.does not in (PageRequest.SCRIPT, PageRequest.ASK)]
    for _, key in told:
        window.page.keyboard.press(PLAYWRIGHT_NAMES.get(key, key.replace("Ctrl", "Control")))
    until(lambda: len(asked) >= len(told), "the actions")
    assert asked == [action.id for action, _ in told]
    assert window.settled() == before


def test_a_question_is_asked_and_its_answer_told(page: Page, open_window: Opener) -> None:
    answers: list[tuple[str, str]] = []
    page.on_answer(lambda action, text: answers.append((action, text)))
    window = open_window(page.url)
    question = window.page.get_by_role("dialog")
    window.page.keyboard.press("G")
    expect(question).to_contain_text("Seconds since the first scan")
    window.page.keyboard.press("Escape")
    expect(question).to_have_count(0)
    window.page.keyboard.press("G")
    window.page.keyboard.type("42.5")
    window.page.keyboard.press("Enter")
    expect(question).to_have_count(0)
    window.page.keyboard.press("O")
    question.get_by_role("button", name="office.log.gz").click()
    until(lambda: len(answers) == 2, "both answers")
    assert answers == [("go-to-second", "42.5"), ("open-log", "office.log.gz")]


def test_keys_do_nothing_on_the_map_while_a_person_types(page: Page, open_window: Opener) -> None:
    asked: list[str] = []
    page.on_action(asked.append)
    page.server.gui.add_text("Path", "")
    window = open_window(page.url)
    field = window.page.get_by_role("textbox").first
    field.click()
    window.page.keyboard.type("f a. ")
    assert field.input_value() == "f a. "
    window.page.mouse.click(400, 300)
    window.page.keyboard.press("d")
    until(lambda: asked, "the next key")
    assert asked == ["dark"]


def test_keys_go_to_the_map_again_once_the_mouse_has_worked_a_widget(page: Page, open_window: Opener) -> None:
    asked: list[str] = []
    page.on_action(asked.append)
    box = page.server.gui.add_checkbox("Beams", False)
    button = page.server.gui.add_button("Optimise")
    presses: list[int] = []
    button.on_click(lambda event: presses.append(1))
    window = open_window(page.url)
    window.page.locator("input[type=checkbox]:visible").click()
    until(lambda: box.value, "the box to be ticked")
    window.page.keyboard.press("Space")
    window.page.get_by_role("button", name="Optimise").click()
    window.page.keyboard.press("Space")
    window.page.keyboard.press("ArrowLeft")
    until(lambda: len(asked) >= 3, "the keys")
    assert asked == ["play", "play", "previous-scan"]
    assert box.value
    window.page.get_by_role("button", name="Optimise").focus()
    window.page.keyboard.press("Space")
    until(lambda: len(presses) == 2, "the focused button to take the key")
    assert asked == ["play", "play", "previous-scan"]


def test_the_palette_finds_an_action_and_does_it(page: Page, open_window: Opener) -> None:
    asked: list[str] = []
    page.on_action(asked.append)
    page.send("refusals", {"optimise": "There is no map yet."})
    window = open_window(page.url)
    before = window.settled()
    window.page.keyboard.press("Control+k")
    name = window.page.get_by_role("combobox", name="Name of an action")
    expect(name).to_be_focused()
    name.fill("solve map")
    expect(window.page.get_by_role("option")).to_have_count(1)
    expect(window.page.get_by_role("option")).to_contain_text("There is no map yet.")
    name.fill("10 scans")
    name.press("ArrowDown")
    name.press("Enter")
    until(lambda: asked, "the action")
    assert asked == ["back-10"]
    expect(name).to_be_hidden()
    window.page.keyboard.press("/")
    expect(name).to_be_visible()
    window.page.keyboard.press("Escape")
    expect(name).to_be_hidden()
    assert window.settled() == before


def test_the_help_sheet_names_every_key(page: Page, open_window: Opener) -> None:
    window = open_window(page.url)
    window.page.keyboard.press("?")
    sheet = window.page.get_by_role("dialog", name="Keys and help")
    expect(sheet).to_be_visible()
    shown = sheet.locator("kbd").all_inner_texts()
    assert sorted(shown) == sorted(action.shown for action in ACTIONS.values() if action.keys)
    window.screenshot("help-sheet")
    window.page.keyboard.press("?")
    expect(sheet).to_be_hidden()
