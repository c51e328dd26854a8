// Draws a .glb with three.js in headless Chromium, on SwiftShader, and prints what it took as JSON: run by script/scoreboard as
//   node three_frames.mjs '{"modules", "chromium", "scene", "picture", "width", "height", "camera", "sky", "frames"}'
// "modules" is the node_modules that holds three and puppeteer-core.
import fs from 'node:fs';
import http from 'node:http';
import path from 'node:path';
import {createRequire} from 'node:module';
import {pathToFileURL} from 'node:url';

const options = JSON.parse(process.argv[2]);
const require = createRequire(path.join(options.modules, 'any.js'));
const puppeteer = (await import(pathToFileURL(require.resolve('puppeteer-core')))).default;

const page_html = `<!DOCTYPE html><script type="importmap">{"imports": {
  "three": "/three/build/three.module.js", "three/addons/": "/three/examples/jsm/"}}</script>
<script type="module" src="/page.js"></script>`;
const types = {'.js': 'text/javascript', '.html': 'text/html'};

// The file of an address, or null.
function fileOf(url) {
  if (url === '/scene.glb') return options.scene;
  if (url === '/sky.hdr') return options.sky;
  if (url === '/page.js') return path.join(import.meta.dirname, 'three_page.js');
  return url.startsWith('/three/') && !url.includes('..') ? path.join(options.modules, url) : null;
}

function serve() {
  const server = http.createServer((request, response) => {
    if (request.url === '/') return response.setHeader('Content-Type', 'text/html').end(page_html);
    const file = fileOf(request.url);
    if (!file || !fs.existsSync(file)) return response.writeHead(404).end();
    response.setHeader('Content-Type', types[path.extname(file)] ?? 'application/octet-stream');
    fs.createReadStream(file).pipe(response);
  });
  return new Promise(done => server.listen(0, '127.0.0.1', () => done(server)));
}

async function openPage(browser, port) {
  const page = await browser.newPage();
  page.setDefaultTimeout(0);
  page.on('pageerror', error => console.error(`three.js: ${error}`));
  page.on('console', message => {
    const of_page = !message.location().url?.endsWith('/favicon.ico');
    if (message.type() === 'error' && of_page) console.error(`three.js: ${message.text()}`);
  });
  await page.goto(`http://127.0.0.1:${port}/`);
  await page.waitForFunction('window.setUp');
  return page;
}

// Milliseconds of processor time that this process and its descendants have spent, in ticks of 10 ms.
function processorTime() {
  const stats = new Map();
  for (const id of fs.readdirSync('/proc').filter(name => /^[0-9]+$/.test(name))) {
    try {
      const text = fs.readFileSync(`/proc/${id}/stat`, 'utf8');
      const words = text.slice(text.lastIndexOf(')') + 2).split(' ');
      stats.set(+id, {parent: +words[1], ticks: +words[11] + +words[12]});
    } catch { /* it has ended */ }
  }
  const isOurs = id => id === process.pid || (stats.has(id) && isOurs(stats.get(id).parent));
  return 10 * [...stats].filter(([id]) => isOurs(id)).reduce((sum, [, {ticks}]) => sum + ticks, 0);
}

async function measure(page) {
  const names = await page.evaluate(o => window.setUp(o), {
    width: options.width, height: options.height, cameraIndex: options.camera, sky: !!options.sky});
  const picture = await page.evaluate(() => window.drawPicture());
  fs.writeFileSync(options.picture, Buffer.from(picture.split(',')[1], 'base64'));
  const frames = [], processor = [];
  for (let i = 0; i < options.frames; ++i) {
    const spent = processorTime();
    frames.push(await page.evaluate(s => window.drawFrame(s), 1e-4 * (i + 1)));
    processor.push(processorTime() - spent);
  }
  return {version: names.version, gl: names.gl, frames_ms: frames, processor_ms: processor};
}

const server = await serve();
const browser = await puppeteer.launch({
  executablePath: options.chromium, headless: true, protocolTimeout: 0, pipe: true, // ends with its pipe
  args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
    '--ignore-gpu-blocklist', '--disable-background-networking', '--disable-gpu-watchdog'],
});
try {
  const page = await openPage(browser, server.address().port);
  console.log(JSON.stringify(await measure(page)));
} finally {
  await browser.close();
  server.close();
}
