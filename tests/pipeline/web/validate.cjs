// Prints the errors of the Khronos validator for each file: node validate.cjs FOLDER_OF_PACKAGES FILE.glb...
const path = require('path'), fs = require('fs');
const validator = require(path.join(process.argv[2], 'gltf-validator'));
(async () => {
  let errors = 0;
  for (const file of process.argv.slice(3)) {
    const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), {maxIssues: 0});
    errors += report.issues.numErrors;
    console.log(path.basename(file) + ': ' + report.issues.numErrors + ' errors, ' + report.issues.numWarnings + ' warnings');
    for (const m of report.issues.messages) if (m.severity === 0) console.log('  ' + m.code + ' ' + m.pointer + ': ' + m.message);
  }
  process.exit(errors ? 1 : 0);
})();
