"""The style of the side bar's texts and rows, as one style sheet for the whole page."""

from __future__ import annotations

TEXTS = """
.ss{font-size:12px;line-height:1.4;padding:2px 8px;overflow-wrap:anywhere}
.ss table{border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums;overflow-wrap:normal}
.ss .dense{font-size:11px}
.ss .dense th,.ss .dense td{padding:2px;white-space:nowrap}
.ss th{font-weight:600;text-align:left;padding:2px 4px;border-bottom:1px solid #8886;vertical-align:bottom}
.ss td{padding:2px 4px;border-bottom:1px solid #8883;vertical-align:top}
.ss td.n,.ss th.n{text-align:right}
.ss .pairs .dim{white-space:nowrap}
.ss .pairs .n{overflow-wrap:anywhere}
.ss tr.open td{border:0;padding-bottom:0}
.ss tr.lead{cursor:pointer}
.ss tr.lead:hover td{background:#8882}
.ss tr.lead button{all:unset;text-decoration:underline;text-underline-offset:2px}
.ss tr.lead button:focus-visible{outline:2px solid #e69f00}
.ss .dense td.wrap{white-space:normal;padding-top:0}
.ss tr.on td{background:#0072b244}
.ss .two th:nth-child(2){border-bottom:2px solid #56b4e9}
.ss .two th:nth-child(3){border-bottom:2px dashed #e69f00}
.ss p{margin:4px 0}
.ss ul{margin:4px 0;padding-left:18px}
.ss .dim{opacity:.72}
.ss .bad{border-left:3px solid #d55e00;padding-left:6px;margin:6px 0}
.ss .ask{border-left:3px solid #cc79a7;padding-left:6px;margin:6px 0}
.ss .drawing{display:block;width:100%;margin:4px 0}
.ss .keys{font-size:11px;line-height:1.3}
.ss .keys td{padding:0 4px;border:0}
.ss .acts{margin:6px 0}
.ss .acts:has(>span){display:grid;grid-template-columns:58px 1fr;column-gap:6px;align-items:baseline}
.ss .acts>span{opacity:.72}
.ss .acts>div{display:flex;flex-wrap:wrap;gap:4px}
.ss .act{all:unset;box-sizing:border-box;padding:2px 8px;border:1px solid #3c8fc4;border-radius:5px;cursor:pointer}
.ss .act:hover{background:#0072b244}
.ss .act:focus-visible{outline:2px solid #e69f00}
.ss .act.strong{background:#0072b2;border-color:#0072b2;color:#fff}
.ss .act[aria-disabled]{border:1px dashed #8888;background:none;color:inherit;opacity:.45;cursor:not-allowed}
.ss .peek{display:flex;flex-direction:column;height:clamp(176px,25vh,290px)}
.ss .peek>div:first-child{flex:1;overflow:auto;scrollbar-width:thin}
.ss .peek>div:first-child>p:first-child{margin-top:0}
.ss .past{max-height:96px;overflow:auto;scrollbar-width:thin}
.ss .past td:first-child{white-space:normal}
.ss .head{display:flex;align-items:baseline;gap:8px;min-height:24px}
.ss .head :is(b,span){overflow:hidden;text-overflow:ellipsis;white-space:nowrap}
.ss .head b{flex:none;max-width:50%}
.ss .head b:only-child{max-width:100%}
.ss .head span{flex:1;text-align:right;opacity:.72}
.ss .meter{height:3px;margin:2px 0 6px;border-radius:2px;overflow:hidden}
.ss .meter i{display:block;height:100%;background:#0072b2}
.ss kbd{border:1px solid #8888;border-radius:3px;padding:0 4px;white-space:nowrap;font-family:inherit}
"""

CHECKBOXES = """
.mantine-Flex-root:has(> div input[type=checkbox]){flex-direction:row-reverse;justify-content:flex-end;gap:8px}
.mantine-Flex-root:has(> div input[type=checkbox]) > div:first-child{width:auto !important}
.mantine-Flex-root:has(> div input[type=checkbox]) > div:last-child{flex-grow:0 !important}
.mantine-Flex-root:has(> div input[type=checkbox]) p{letter-spacing:normal !important}
div:has(> .mantine-Flex-root > div input[type=checkbox]){padding-bottom:1px !important}
"""
"""The box before its text, the text in one line: the viewer leaves a third of the width to it."""

TABS = """
[role=tab]{padding-left:4px !important;padding-right:4px !important}
"""
"""All of them in one row."""

STYLE = f"<style>{TEXTS}{CHECKBOXES}{TABS}</style>"
