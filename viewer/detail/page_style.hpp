#pragma once

namespace angio::viewer::detail {

/// The report's style sheet: one column that fits paper and screens, light and dark.
inline constexpr const char* kPageStyle = R"css(
:root{color-scheme:light dark;--paper:#fff;--ink:#1d2128;--soft:#5b6472;--line:#d9dde3;
--panel:#f5f6f8;--warn:#fff4dc;--warn-line:#e0a526;--c1:#1f6fc4;--c2:#d9690f;--c3:#23864a;
--c4:#8a4fb8;--grid:#e6e8ec;--band:#f1f3f6;
--n1:#1a5ca3;--n2:#a84f00;--n3:#1b6b3a;--n4:#6f3f95}
@media (prefers-color-scheme:dark){:root{--paper:#15181d;--ink:#e7eaef;--soft:#a3adba;
--line:#353c47;--panel:#1e232b;--warn:#3a2f14;--warn-line:#c08a1a;--c1:#6cb2f7;--c2:#f7a35c;
--c3:#6fd08f;--c4:#c79bea;--grid:#2b313a;--band:#1c2027;
--n1:#8cc4fa;--n2:#f9b880;--n3:#8bdba5;--n4:#d5b5f0}}
*{box-sizing:border-box}
body{margin:0 auto;max-width:1060px;padding:28px 24px 60px;background:var(--paper);
color:var(--ink);font:15px/1.5 system-ui,"Segoe UI",Roboto,"Helvetica Neue",Arial,sans-serif}
h1{font-size:27px;line-height:1.2;margin:0 0 2px;overflow-wrap:anywhere}
h2{font-size:19px;margin:38px 0 10px;padding-top:14px;border-top:1px solid var(--line)}
h3{font-size:15px;margin:0 0 6px}
p{margin:6px 0}
.sub{color:var(--soft)}
.notice{border-left:4px solid var(--warn-line);background:var(--warn);padding:10px 14px;
border-radius:4px;margin:14px 0}
.notice ul{margin:4px 0 0;padding-left:20px}
.cards{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(290px,100%),1fr));gap:12px;
margin:18px 0}
.card{background:var(--panel);border:1px solid var(--line);border-radius:8px;padding:13px 16px}
.card .value{font-size:23px;font-weight:650}
.card .label{font-weight:600}
.card .detail{color:var(--soft);font-size:13.5px}
.trial{border:1px dashed var(--soft);border-radius:8px;padding:8px 14px 2px;margin:18px 0}
.trial .cards{margin:8px 0 12px}
.trial .card{background:none}
.trial .card .value{font-weight:400;color:var(--soft)}
figure{margin:0 0 16px;break-inside:avoid}
figcaption{color:var(--soft);font-size:13.5px;margin-top:5px}
img{max-width:100%;height:auto;display:block;border:1px solid var(--line);border-radius:6px;
background:#fff}
.row{display:grid;gap:14px;grid-template-columns:repeat(3,1fr)}
.row img{width:100%}
.pairs{display:grid;gap:14px;grid-template-columns:repeat(2,1fr)}
.pairs img{width:100%}
.tiles{display:grid;gap:6px 12px;grid-template-columns:repeat(4,1fr)}
.tiles img{width:100%}
.sections{display:grid;gap:8px 24px;grid-template-columns:minmax(0,420px) minmax(0,1fr);align-items:center}
#section-view{width:100%;background:#181a1e;border-radius:6px;display:block}
#section-view path{fill:none;stroke-width:1.6}
#section-view .before{stroke:#46c8ff}#section-view .peak{stroke:#7ee081;stroke-dasharray:4 3}
#section-view .after{stroke:#ffa028}#section-view .scale{stroke:#fff;stroke-width:3}
.key.before{background:#46c8ff}.key.peak{background:#7ee081}.key.after{background:#ffa028}
#section-slider input{width:100%;accent-color:var(--c1)}
.swatch{display:inline-block;width:16px;height:12px;border:1px solid #555;vertical-align:-1px;
margin:0 4px 0 8px}
.hatched{background:repeating-linear-gradient(-45deg,#c0392b 0 2px,#fff 2px 5px)}
.tree img{margin:0 auto;max-height:760px;width:auto}
.stack img{width:100%}
.charts{display:grid;gap:18px;grid-template-columns:repeat(auto-fit,minmax(min(430px,100%),1fr))}
.tables{display:grid;gap:22px;grid-template-columns:repeat(auto-fit,minmax(min(330px,100%),1fr));
align-items:start}
.wide{overflow-x:auto;background:linear-gradient(90deg,var(--paper) 30%,transparent) 0 0/44px 100% local,
linear-gradient(270deg,var(--paper) 30%,transparent) 100% 0/44px 100% local,
linear-gradient(90deg,#80808080,transparent) 0 0/12px 100% scroll,
linear-gradient(270deg,#80808080,transparent) 100% 0/12px 100% scroll;background-repeat:no-repeat}
.key{display:inline-block;width:22px;height:3px;vertical-align:middle;margin:0 5px 0 12px}
table{border-collapse:collapse;width:100%;font-size:14px}
th,td{border-bottom:1px solid var(--line);padding:4px 6px;vertical-align:top}
th{font-weight:400;color:var(--soft);text-align:left}
td{text-align:right;overflow-wrap:anywhere;font-variant-numeric:tabular-nums}
th[scope=col]:not(:first-child){text-align:right}
svg.chart{width:100%;height:auto;display:block;font:12px system-ui,Arial,sans-serif}
.on-narrow{display:none}
:focus-visible{outline:3px solid var(--c1);outline-offset:2px}
svg .grid{stroke:var(--grid)}
svg .axis{stroke:var(--soft)}
svg .band{fill:var(--band)}
svg .level{stroke:var(--soft);stroke-dasharray:7 5}
svg text{fill:var(--ink)}
svg .tick{fill:var(--soft)}
svg .note{font-weight:600}
svg .n1{fill:var(--n1)}svg .n2{fill:var(--n2)}svg .n3{fill:var(--n3)}svg .n4{fill:var(--n4)}
svg .note,svg .halo{paint-order:stroke;stroke:var(--paper);stroke-width:3px;stroke-linejoin:round}
svg .mid{text-anchor:middle}
svg .end{text-anchor:end}
svg .line{fill:none;stroke-width:2;stroke-linejoin:round}
svg .dashed{stroke-dasharray:3 4;stroke-width:1.4}
svg .s1{stroke:var(--c1)}svg .s2{stroke:var(--c2)}svg .s3{stroke:var(--c3)}
svg .s4{stroke:var(--c4)}
svg .hatching{fill:none;stroke:#c0392b;stroke-width:1.6}
svg .on-map{font-weight:600;fill:#111;paint-order:stroke;stroke:#fff;stroke-width:4px}
svg .hover{fill:transparent;stroke:none}
svg .hover:hover{fill:currentColor;fill-opacity:.35}
svg .mark{stroke:var(--paper);stroke-width:1.5}
svg .mark.s1{fill:var(--c1)}svg .mark.s2{fill:var(--c2)}
svg .mark.s3{fill:var(--c3)}svg .mark.s4{fill:var(--c4)}
#scene fieldset{border:0;padding:0;margin:0;display:flex;flex-wrap:wrap;gap:4px 14px}
#scene legend{display:contents}
.scene-view{height:min(560px,75vh);border:1px solid var(--line);border-radius:6px;overflow:hidden;
touch-action:none}
.scene-view canvas{display:block;width:100%!important;height:100%!important}
.scene-row{display:flex;flex-wrap:wrap;align-items:center;gap:6px 14px;margin:8px 0}
.scene-slider{display:flex;align-items:center;gap:8px;flex:1 1 240px}
.scene-slider input{flex:1;min-width:120px;accent-color:var(--c1)}
#scene button,#scene select{font:inherit;color:inherit;background:var(--panel);
border:1px solid var(--line);border-radius:6px;padding:4px 12px}
#scene output{color:var(--soft);font-variant-numeric:tabular-nums;min-width:13em}
.scene-key i{display:inline-block;width:150px;height:12px;margin:0 8px;vertical-align:middle}
@media (max-width:700px){.row,.pairs,.sections{grid-template-columns:1fr}
.tiles{grid-template-columns:1fr 1fr}.charts{grid-template-columns:1fr}
.on-wide{display:none}.on-narrow{display:block}#scene svg.chart{font-size:20px}body{padding:16px 14px 40px}}
@media print{#scene-part,#section-slider{display:none}td:not(.text){white-space:nowrap}:root{color-scheme:light;--paper:#fff;--ink:#000;--soft:#444;--line:#bbb;
--panel:#fff;--warn:#fff;--grid:#ddd;--band:#f3f3f3;--c1:#1f6fc4;--c2:#d9690f}
body{max-width:none;padding:0;font-size:11.5px}h2{break-after:avoid}
.tree img{max-height:430px}.card,figure,.table{break-inside:avoid}.card .value{font-size:17px}
.cards{grid-template-columns:repeat(3,1fr)}.charts{grid-template-columns:1fr 1fr}}
)css";

}  // namespace angio::viewer::detail
